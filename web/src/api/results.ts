/** What an evaluation found: results.json, in the types that the API gives out. */

import { useQuery } from "@tanstack/react-query";

import { answer, api, type Schemas } from "./client";

export type Found = Schemas["Decided"];

/** Of the latest job of the study that succeeded. */
export function useStudyResults(studyId: string | undefined) {
  return useQuery({
    queryKey: ["results", studyId],
    enabled: studyId !== undefined,
    staleTime: 60_000,
    queryFn: ({ signal }) =>
      answer(
        api.GET("/api/v1/studies/{study_id}/results", { params: { path: { study_id: studyId ?? "" } }, signal }),
      ),
  });
}
