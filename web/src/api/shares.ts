import { useQuery, useQueryClient } from "@tanstack/react-query";

import { answer, api, type Schemas, whole } from "./client";
import { useSession } from "./session";

export type Share = Schemas["ShareOut"];

/** Who else may read a study of one's own lab; nothing where one is its reader, or there are no accounts. */
export function useShares(studyId: string) {
  const { data: session } = useSession();
  return useQuery({
    queryKey: ["shares", studyId],
    queryFn: ({ signal }) =>
      whole((query) => answer(api.GET("/api/v1/studies/{study_id}/shares", { params: { path: { study_id: studyId }, query }, signal }))),
    enabled: session?.accounts === true && session.lab !== null,
    retry: false,
  });
}

/** Studies that other labs let this one read. */
export function useShared() {
  const { data: session } = useSession();
  return useQuery({
    queryKey: ["shared"],
    queryFn: ({ signal }) => whole((query) => answer(api.GET("/api/v1/shared", { params: { query }, signal }))),
    enabled: session?.accounts === true && session.lab !== null,
  });
}

export function useShareDeeds(study_id: string) {
  const cache = useQueryClient();
  const again = () => cache.invalidateQueries({ queryKey: ["shares", study_id] });
  return {
    share: async (lab: string | null) => {
      await answer(api.POST("/api/v1/studies/{study_id}/shares", { params: { path: { study_id } }, body: { lab } }));
      await again();
    },
    end: async (share_id: string) => {
      await answer<unknown>(api.DELETE("/api/v1/studies/{study_id}/shares/{share_id}", { params: { path: { study_id, share_id } } }));
      await again();
    },
  };
}
