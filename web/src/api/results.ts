/** What an evaluation found: results.json, as docs/study.md describes it. Only the keys that pages here read. */

import { useQuery } from "@tanstack/react-query";

import { answer, api } from "./client";

export type Figure = { value: number | null; std: number | null; unit: string };
export type Identified = Figure & { prior: number | null; identifiable: boolean };
export type JointResult = { joint: string } & Record<string, Identified | undefined>;
export type Results = {
  name: string;
  robot: string;
  identification: { joints: JointResult[]; cutoff_hz: number };
};

/** Of the latest job of the study that succeeded. */
export function useStudyResults(studyId: string | undefined) {
  return useQuery({
    queryKey: ["results", studyId],
    enabled: studyId !== undefined,
    staleTime: 60_000,
    queryFn: ({ signal }) =>
      answer(
        api.GET("/api/v1/studies/{study_id}/results", { params: { path: { study_id: studyId ?? "" } }, signal }),
      ) as unknown as Promise<Results>,
  });
}
