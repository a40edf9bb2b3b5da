/** A file as it was handed in. */

import { useQuery } from "@tanstack/react-query";

import { answer } from "./client";
import { fromService } from "./refusal";

export async function fetchFile(href: string, signal?: AbortSignal): Promise<Blob> {
  const asked = async () => {
    const response = fromService(await fetch(href, { signal, redirect: "manual" }));
    if (response.ok) return { data: await response.blob(), response };
    return { error: (await response.json().catch(() => null)) as unknown, response };
  };
  return answer<Blob>(asked());
}

export function useTextFile(href: string | undefined) {
  return useQuery({
    queryKey: ["file", href],
    enabled: href !== undefined,
    staleTime: Infinity,
    queryFn: async ({ signal }) => (await fetchFile(href ?? "", signal)).text(),
  });
}
