import { useQuery, useQueryClient } from "@tanstack/react-query";

import { answer, api, type Schemas } from "./client";

export type Webhook = Schemas["WebhookOut"];
export type Event = Schemas["NewWebhook"]["events"][number];

export function useWebhooks() {
  return useQuery({ queryKey: ["webhooks"], queryFn: ({ signal }) => answer(api.GET("/api/v1/webhooks", { signal })) });
}

/** What one was told, newest first; asked again while it is looked at. */
export function useDeliveries(webhook_id: string) {
  return useQuery({
    queryKey: ["webhooks", webhook_id, "deliveries"],
    refetchInterval: 5000,
    queryFn: ({ signal }) =>
      answer(api.GET("/api/v1/webhooks/{webhook_id}/deliveries", { params: { path: { webhook_id }, query: { limit: 10 } }, signal })),
  });
}

export function useWebhookDeeds() {
  const cache = useQueryClient();
  const then = async <T>(asked: Promise<T>): Promise<T> => {
    const got = await asked;
    await cache.invalidateQueries({ queryKey: ["webhooks"] });
    return got;
  };
  const of = (webhook_id: string) => ({ params: { path: { webhook_id } } });
  return {
    add: (url: string, events: Event[]) => then(answer(api.POST("/api/v1/webhooks", { body: { url, events } }))),
    remove: (id: string) => then(answer<unknown>(api.DELETE("/api/v1/webhooks/{webhook_id}", of(id)))),
    enable: (id: string) => then(answer<unknown>(api.POST("/api/v1/webhooks/{webhook_id}/enable", of(id)))),
    ping: (id: string) => then(answer<unknown>(api.POST("/api/v1/webhooks/{webhook_id}/ping", of(id)))),
  };
}
