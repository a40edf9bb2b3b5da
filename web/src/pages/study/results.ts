/** results.json as `docs/study.md` describes it, and how the page gets it. */

import { useQuery } from "@tanstack/react-query";

import { answer, api } from "../../api/client";
import type { Configuration, Scope } from "./scope";

export type Num = number | null;
export type Measured = { value: Num; std: Num; unit: string };
export type Place = Record<string, string | boolean>;

export type Pooled = {
  kind: string;
  channels: string[];
  logs: string[];
  unit: string;
  held_out: boolean;
  rmse_prior: Num;
  rmse_identified: Num;
  noise_floor: Num;
};

export type Fit = {
  channel: string;
  unit: string;
  log: string;
  held_out: boolean;
  rmse_prior: Num;
  rmse_identified: Num;
  noise_floor: Num;
  rmse_moving?: Num;
};

/** Seconds in steady motion, of those in motion, of one joint. */
export type SteadyShare = {
  joint: string;
  fitted_s: Num;
  fitted_of_s: Num;
  held_out_s: Num;
  held_out_of_s: Num;
  both_directions: boolean;
};

export type Parameter = {
  name: string;
  value: Num;
  std: Num;
  unit: string;
  prior: Num;
  prior_std: Num;
  identifiable: boolean;
  combination?: Record<string, number>;
};

/** A sensor inside the robot: the bodies beyond it, and its zero, by component fx … mz. */
export type SensorFound = { sensor: string; carries: string[]; zero: Record<string, Measured & { identifiable: boolean }> };

export type Identification = {
  summary: Pooled[];
  validation: Fit[];
  steady?: SteadyShare[];
  parameters: Parameter[];
  sensors?: SensorFound[];
  unidentifiable: string[];
  consistent_links: Record<string, boolean>;
  prior_strength: Num;
  rank: number;
  condition: Num;
  samples: number;
  cutoff_hz: Num;
};

export type Effort = { peak: Measured; mean: Measured; integral: Measured };
export type Approach = "A" | "B" | "prior" | "band_model";

export type Support = {
  device: string;
  motion: string;
  joint: string;
  unit: string;
  main: boolean;
  logs: string[];
  references: string[];
  rmse_a: Num;
  rmse_b: Num;
  rmse_prior: Num;
  motion_equality: { verdict: string; q_rms: Num; dq_rms: Num; dq_share: Num; lag_s: Num } | null;
  approaches: Partial<Record<Approach, Effort & { spread: Num }>>;
  phases: { phase: string; duration_s: number; approaches: Partial<Record<Approach, Effort>> }[];
  masked_share: Num;
  rest_share: Num;
  rest_half_width: Num;
  band_model: string | null;
};

export type Stiffness = {
  device: string;
  approach: string;
  band: string;
  group: string;
  stiffness_n_per_m: Measured;
  natural_length_m: Measured;
  interval_95: { stiffness_n_per_m: [Num, Num]; natural_length_m: [Num, Num] };
  truth_n_per_m: Num;
  error_percent: Num;
  identifiable: boolean;
  length_identifiable: boolean;
  note: string;
};

export type StiffnessDetails = {
  device: string;
  approach: string;
  rms: Record<string, Num>;
  samples: number;
  notes: string[];
};

/** title: in words, where the service wrote one. */
export type Candidate = { effect: string; where: Place; title?: string; score: Num; reason: string };

export type Curve = {
  coordinate: { name: string; unit: string; values: Num[] };
  unit: string;
  before: Num[];
  after: Num[];
  spread: Num[];
  model: Num[];
};

export type Finding = {
  rank: number;
  effect: string;
  where: Place;
  title?: string;
  parameters: Record<string, Measured>;
  held_out: { channel: string; unit: string; rmse_before: Num; rmse_after: Num; noise_floor: Num; log?: string };
  score: Num;
  evidence: string;
  alternatives: Candidate[];
  also_possible: Candidate[];
  motion: string;
  planned?: { file: string; joint: string }[];
  curve: Curve;
};

/** unit: `floors` where channels of several units are told in multiples of their noise floors. */
export type Link = {
  step: string;
  rmse: Num;
  noise_floor: Num;
  unit: string;
  worst: string;
  worst_rmse: Num;
  worst_floor: Num;
};

export type Excess = { channel: string; unit: string; rmse: Num; noise_floor: Num; z: Num; where: string };

export type Discrepancy = {
  verdict: "effects" | "unexplained" | "undecided" | "none";
  left?: "above" | "open" | "nothing";
  reason?: string;
  sentence?: string;
  left_sentence?: string;
  findings: Finding[];
  chain: Link[];
  wear_chain?: Link[];
  located: Excess[];
  unexplained: Excess[];
  rejected: Candidate[];
  lineage: { version: string; parent: string | null; added: string }[];
  candidates: number;
  notes: string[];
  before_after: Record<string, { before: Measured; after: Measured }>;
};

export type Doubt = {
  log: string;
  severity: string;
  channel: string | null;
  rule: string;
  detail: string;
  advice: string;
};

export type Results = {
  name: string;
  robot: string;
  scope?: Scope;
  configuration?: Configuration;
  software: Record<string, string>;
  inputs: { file: string; sha256: string; bytes: number }[];
  steps: { step: string; status: "done" | "skipped" | "failed"; reason?: string }[];
  settings: Record<string, unknown>;
  warnings: string[];
  doctor: Doubt[];
  identification: Identification;
  support: Support[];
  stiffness: Stiffness[];
  stiffness_details: StiffnessDetails[];
  discrepancy: Discrepancy | null;
  reading?: Reading;
};

/** The service's sentences on how to read numbers; results of before have none. */
export type Reading = { steady: string; steady_seconds: string; support_table: string; support_interval: string };

/** What a job found; what it made never changes. */
export function useResults(jobId: string, ready: boolean) {
  return useQuery({
    queryKey: ["results", jobId],
    queryFn: async ({ signal }) =>
      (await answer(
        api.GET("/api/v1/jobs/{job_id}/results", { params: { path: { job_id: jobId } }, signal }),
      )) as unknown as Results,
    staleTime: Infinity,
    enabled: ready,
  });
}

export function useArtifacts(jobId: string, ready: boolean) {
  return useQuery({
    queryKey: ["artifacts", jobId],
    queryFn: ({ signal }) =>
      answer(api.GET("/api/v1/jobs/{job_id}/artifacts", { params: { path: { job_id: jobId } }, signal })),
    staleTime: Infinity,
    enabled: ready,
  });
}

/** Whether results.json is that of an evaluation: other kinds of jobs write others. */
export function isEvaluation(results: Results | undefined): results is Results {
  return results?.identification !== undefined;
}
