/** The typed client. `answer(api.GET(…))` gives the body, or throws a `Refusal`. */

import createClient from "openapi-fetch";

import { basename } from "../app/base";
import { answered, failed } from "./reachable";
import { fromService, noAnswer, Refusal, refusalOf } from "./refusal";
import type { components, paths } from "./schema";

export type Schemas = components["schemas"];

export const api = createClient<paths>({
  baseUrl: window.location.origin + basename,
  redirect: "manual",
  querySerializer: { array: { style: "form", explode: true } },
});

api.use({
  onRequest({ request }) {
    if (request.method === "POST") request.headers.set("Idempotency-Key", newKey());
    return request;
  },
  onResponse: ({ response }) => void fromService(response),
});

export async function answer<T>(asked: Promise<{ data?: T; error?: unknown; response: Response }>): Promise<T> {
  let got;
  try {
    got = await asked;
  } catch (error) {
    if (error instanceof DOMException && error.name === "AbortError") throw error;
    const refusal = error instanceof Refusal ? error : noAnswer();
    failed(refusal);
    throw refusal;
  }
  if (!got.response.ok) {
    const refusal = refusalOf(got.response.status, got.response.statusText, got.error);
    failed(refusal);
    throw refusal;
  }
  answered();
  return got.data as T;
}

type Page<T> = { items: T[]; next_cursor?: string | null };
/** As long as one can be. */
const limit = 200;

/** A list from its first page to its last. ask: for the page that this query asks for. */
export async function whole<T>(ask: (query: { limit: number; cursor?: string }) => Promise<Page<T>>): Promise<{ items: T[] }> {
  const items: T[] = [];
  let page: Page<T> | undefined;
  do {
    page = await ask({ limit, cursor: page?.next_cursor ?? undefined });
    items.push(...page.items);
  } while (page.next_cursor);
  return { items };
}

/** A key under which a request happens once, however often it is sent. */
export function newKey(): string {
  const bytes = crypto.getRandomValues(new Uint8Array(16));
  return [...bytes].map((byte) => byte.toString(16).padStart(2, "0")).join("");
}
