import { useQuery } from "@tanstack/react-query";

import { answer, api } from "./client";

export function useHealth(everyMs: number) {
  return useQuery({
    queryKey: ["health"],
    queryFn: ({ signal }) => answer(api.GET("/healthz", { signal })),
    refetchInterval: everyMs,
    retry: false,
  });
}
