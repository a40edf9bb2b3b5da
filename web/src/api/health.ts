import { useQuery } from "@tanstack/react-query";

import { answer, api } from "./client";

export function useHealth(everyMs: number) {
  return useQuery({
    queryKey: ["health"],
    queryFn: ({ signal }) => answer(api.GET("/readyz", { signal })),
    refetchInterval: everyMs,
    retry: false,
  });
}

/** Asks for something that a guard in front of the service keeps; health it may let everybody see. */
export function useLetIn(everyMs: number) {
  return useQuery({
    queryKey: ["let in"],
    queryFn: ({ signal }) => answer(api.GET("/api/v1/studies", { params: { query: { limit: 1 } }, signal })),
    refetchInterval: everyMs,
    refetchOnWindowFocus: "always",
    retry: false,
  });
}
