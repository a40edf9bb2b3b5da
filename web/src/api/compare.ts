import { keepPreviousData, useQuery } from "@tanstack/react-query";

import { address } from "../app/base";
import { answer, api, type Schemas } from "./client";

export type Comparison = Schemas["CompareOut"];
export type SupportRow = Schemas["SupportRow"];
export type ComparedJob = Schemas["ComparedJob"];
export type FinishedJob = Schemas["JobOut"];

const KINDS = ["evaluate", "support", "stiffness"];

/** Jobs that have something to compare, newest first. */
export function useFinishedJobs() {
  return useQuery({
    queryKey: ["jobs", "succeeded"],
    queryFn: ({ signal }) =>
      answer(api.GET("/api/v1/jobs", { params: { query: { state: "succeeded", limit: 200 } }, signal })),
    select: ({ items }) => items.filter((job) => KINDS.includes(job.kind)),
  });
}

export function useComparison(jobs: string[]) {
  return useQuery({
    queryKey: ["compare", jobs],
    enabled: jobs.length > 0,
    placeholderData: keepPreviousData,
    staleTime: Infinity,
    queryFn: ({ signal }) =>
      answer(api.GET("/api/v1/compare", { params: { query: { jobs } }, signal })) as Promise<Comparison>,
  });
}

export function exportAddress(jobs: string[], format: "csv" | "latex", table: "support" | "stiffness"): string {
  const asked = new URLSearchParams([...jobs.map((job) => ["jobs", job]), ["format", format], ["table", table]]);
  return address(`api/v1/compare?${asked.toString()}`);
}
