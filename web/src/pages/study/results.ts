/** results.json, in the types that the API gives out, and how the page gets it. */

import { useQuery } from "@tanstack/react-query";

import { answer, api, type Schemas, whole } from "../../api/client";

export type Num = number | null;
export type Results = Schemas["StudyResults"];
/** Of an evaluation, or what another kind of job made. */
export type Answer = Results | Record<string, unknown>;
export type Identification = Schemas["Identification"];
export type Fit = Schemas["ChannelError"];
export type SteadyShare = Schemas["SteadySeconds"];
export type Parameter = Schemas["IdentifiedParameter"];
export type SensorFound = Schemas["SensorZero"];
export type Support = Schemas["Support"];
export type FollowedPlan = Schemas["PlanFollowed"];
export type Approach = keyof Schemas["ByApproach"];
export type Stiffness = Schemas["BandStiffness"];
export type DoubtPart = Schemas["DoubtPart"];
export type DoubtSource = Schemas["DoubtSource"];
export type StiffnessCheck = Schemas["StiffnessCheck"];
export type Discrepancy = Schemas["Discrepancy"];
export type Finding = Schemas["NamedEffect"];
export type Candidate = Schemas["Candidate"];
export type Curve = Schemas["EvidenceCurve"];
export type Link = Schemas["ChainLink"];
export type Excess = Schemas["ChannelExcess"];
export type Measured = Schemas["Measured"];
export type Doubt = Schemas["SignalDoubt"];
export type Reading = Schemas["Reading"];

/** What a job found, of an evaluation or of a what-if; what it made never changes. */
export function useResults(jobId: string, ready: boolean) {
  return useQuery({
    queryKey: ["results", jobId],
    queryFn: ({ signal }) => answer(api.GET("/api/v1/jobs/{job_id}/results", { params: { path: { job_id: jobId } }, signal })),
    staleTime: Infinity,
    enabled: ready,
  });
}

export function useArtifacts(jobId: string, ready: boolean) {
  return useQuery({
    queryKey: ["artifacts", jobId],
    queryFn: ({ signal }) =>
      whole((query) => answer(api.GET("/api/v1/jobs/{job_id}/artifacts", { params: { path: { job_id: jobId }, query }, signal }))),
    staleTime: Infinity,
    enabled: ready,
  });
}

/** Whether they are those of an evaluation: other kinds of jobs write others. */
export function isEvaluation(results: Answer | undefined): results is Results {
  return results !== undefined && "identification" in results;
}
