/** A payload while it is put together: what its files hold, whether it is one by now, and the keeping of it. */

import { keepPreviousData, useQuery } from "@tanstack/react-query";

import { answer, api, type Schemas } from "./client";
import type { Payload } from "./payloads";

export type DraftBody = Schemas["PayloadDraft"];
export type Look = Schemas["PayloadLookOut"];
export type Verdict = Schemas["PayloadVerdictOut"];
export type PayloadFinding = Schemas["PayloadFindingOut"];
export type Urdf = Schemas["UrdfOut"];

export function useLook(body: DraftBody) {
  const { text: _, ...files } = body;
  const some = (files.keep?.length ?? 0) + (files.upload_ids?.length ?? 0) > 0;
  return useQuery({
    queryKey: ["payload-look", files],
    enabled: some,
    placeholderData: some ? keepPreviousData : undefined,
    staleTime: Infinity,
    retry: false,
    queryFn: ({ signal }) => answer(api.POST("/api/v1/payloads/look", { body: files, signal })),
  });
}

/** doctor: ask it as well, which takes some seconds. */
export function useVerdict(body: DraftBody, doctor: boolean) {
  return useQuery({
    queryKey: ["payload-check", doctor, body],
    placeholderData: keepPreviousData,
    staleTime: Infinity,
    retry: false,
    queryFn: ({ signal }) => answer(api.POST("/api/v1/payloads/check", { params: { query: { doctor } }, body, signal })),
  });
}

export function keepDraft(body: DraftBody): Promise<Payload> {
  return answer(api.POST("/api/v1/payloads/from-draft", { body })) as Promise<Payload>;
}
