/** What was asked is kept here; a refusal on the merits is not asked again, silence is. */

import { QueryClient } from "@tanstack/react-query";

import { Refusal } from "./refusal";

export function newCache(): QueryClient {
  return new QueryClient({
    defaultOptions: {
      queries: {
        networkMode: "always",
        staleTime: 5_000,
        retry: (count, error) => count < 2 && !(error instanceof Refusal && !error.away),
      },
      mutations: { networkMode: "always", retry: false },
    },
  });
}
