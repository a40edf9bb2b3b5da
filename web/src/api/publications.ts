import { useQuery, useQueryClient } from "@tanstack/react-query";

import { address } from "../app/base";
import { answer, api, type Schemas } from "./client";
import { fetchFile } from "./files";
import type { Results } from "../pages/study/results";

export type Publication = Schemas["PublicationOut"];
export type Published = Schemas["PublishedOut"];
export type NewPublication = Schemas["NewPublication"];

/** What was published of a study of one's own lab, newest first. */
export function usePublications(study_id: string) {
  return useQuery({
    queryKey: ["publications", study_id],
    queryFn: ({ signal }) => answer(api.GET("/api/v1/publications", { params: { query: { study_id, limit: 200 } }, signal })),
    retry: false,
  });
}

export function usePublicationDeeds(study_id: string) {
  const cache = useQueryClient();
  const then = async <T>(asked: Promise<T>): Promise<T> => {
    const got = await asked;
    await cache.invalidateQueries({ queryKey: ["publications", study_id] });
    return got;
  };
  return {
    publish: (body: NewPublication) =>
      then(answer(api.POST("/api/v1/studies/{study_id}/publications", { params: { path: { study_id } }, body }))),
    revoke: (publication_id: string, reason: string) =>
      then(answer(api.POST("/api/v1/publications/{publication_id}/revoke", { params: { path: { publication_id } }, body: { reason } }))),
  };
}

/** By the last part of its permalink; whoever asks. */
export function usePublished(key: string) {
  return useQuery({
    queryKey: ["published", key],
    queryFn: ({ signal }) => answer(api.GET("/api/v1/published/{key}", { params: { path: { key } }, signal })),
    retry: false,
  });
}

export const publishedAddress = (key: string, rest: string) => address(`api/v1/published/${key}/${rest}`);
export const publishedFile = (key: string, path: string) =>
  publishedAddress(key, `files/${path.split("/").map(encodeURIComponent).join("/")}`);

export function usePublishedResults(found: Published | undefined) {
  return useQuery({
    queryKey: ["published", found?.key, "results"],
    enabled: found !== undefined && found.revoked_at === null,
    staleTime: Infinity,
    queryFn: async ({ signal }) =>
      JSON.parse(await (await fetchFile(publishedFile(found!.key, "results/results.json"), signal)).text()) as Results,
  });
}
