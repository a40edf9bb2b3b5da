/** Payloads behind a wrist sensor: their list, one of them, what was identified, what is planned, and exports. */

import { keepPreviousData, useInfiniteQuery, useMutation, useQuery, useQueryClient } from "@tanstack/react-query";

import { address } from "../app/base";
import { answer, api, type Schemas } from "./client";
import { isActive } from "./studies";

export type PayloadLog = {
  name: string;
  file: string[];
  role: "postures" | "excitation" | "test" | "contact";
  samples: number;
  rate_hz: number | null;
  duration_s: number | null;
};
export type PayloadSummary = {
  name: string;
  sensor: { frame: string | null; noise: { force_n: number; moment_nm: number } };
  pose: "joints" | "rotation" | "quaternion";
  joints: string[];
  imu: boolean;
  ground_truth: { mass_kg: number | null };
  logs: PayloadLog[];
  plan: { joints: string[] } | null;
  findings?: Schemas["PayloadFindingOut"][];
};
export type Payload = Omit<Schemas["PayloadOut"], "summary"> & { summary: PayloadSummary };
export type PayloadResults = Schemas["PayloadResults"];
export type Value = Schemas["Value"];
export type Plan = Schemas["PlanOut"];
export type What = Schemas["PlanRequest"]["what"];

const PAGE = 100;
const LISTED = 100;
const BUSY_MS = 2_000;
const IDLE_MS = 20_000;

/** Newest first; each version is one of them. */
export function usePayloads(search = "") {
  return useInfiniteQuery({
    queryKey: ["payloads", { search }],
    placeholderData: keepPreviousData,
    queryFn: ({ pageParam, signal }) => {
      const query = { limit: PAGE, cursor: pageParam, search: search || undefined };
      return answer(api.GET("/api/v1/payloads", { params: { query }, signal }));
    },
    initialPageParam: undefined as string | undefined,
    getNextPageParam: (page) => page.next_cursor ?? undefined,
    select: ({ pages }) => pages.flatMap((page) => page.items) as Payload[],
    refetchInterval: ({ state }) => {
      const all = state.data?.pages.flatMap((page) => page.items) ?? [];
      return all.some((payload) => isActive(payload.latest_job?.state)) ? BUSY_MS : IDLE_MS;
    },
  });
}

export function usePayload(id: string) {
  return useQuery({
    queryKey: ["payloads", id],
    queryFn: ({ signal }) =>
      answer(api.GET("/api/v1/payloads/{payload_id}", { params: { path: { payload_id: id } }, signal })) as Promise<Payload>,
    refetchInterval: ({ state }) => (isActive(state.data?.latest_job?.state) ? BUSY_MS : IDLE_MS),
  });
}

/** Its jobs that identify, newest first; plans are asked for on their own. */
export function usePayloadJobs(id: string) {
  return useQuery({
    queryKey: ["jobs", id],
    queryFn: ({ signal }) => answer(api.GET("/api/v1/jobs", { params: { query: { payload_id: id, limit: LISTED } }, signal })),
    select: ({ items }) => items.filter((job) => job.kind === "payload"),
    refetchInterval: ({ state }) => (state.data?.items.some((job) => isActive(job.state)) ? BUSY_MS : IDLE_MS),
  });
}

/** What one job identified, which never changes. */
export function usePayloadResults(jobId: string, ready: boolean) {
  return useQuery({
    queryKey: ["results", jobId],
    queryFn: ({ signal }) =>
      answer(api.GET("/api/v1/jobs/{job_id}/results", { params: { path: { job_id: jobId } }, signal })) as unknown as Promise<PayloadResults>,
    staleTime: Infinity,
    enabled: ready,
  });
}

export function usePlans(id: string) {
  return useQuery({
    queryKey: ["payloads", id, "plans"],
    queryFn: ({ signal }) => answer(api.GET("/api/v1/payloads/{payload_id}/plans", { params: { path: { payload_id: id } }, signal })),
    select: ({ items }) => items as Plan[],
    refetchInterval: ({ state }) => (state.data?.items.some((plan) => isActive(plan.job.state)) ? BUSY_MS : IDLE_MS),
  });
}

export function useAskPlan(id: string) {
  const cache = useQueryClient();
  return useMutation({
    mutationFn: (what: What) =>
      answer(api.POST("/api/v1/payloads/{payload_id}/plans", { params: { path: { payload_id: id } }, body: { what } })),
    onSuccess: () => cache.invalidateQueries({ queryKey: ["payloads", id, "plans"] }),
  });
}

/** flange: the sensor's pose in it, x, y, z [m], roll, pitch, yaw [°]; null: all in the sensor's frame. */
export function exportAddress(id: string, format: string, flange: readonly number[] | null): string {
  const asked = new URLSearchParams((flange ?? []).map((value) => ["flange", String(value)]));
  return address(`api/v1/payloads/${id}/exports/${format}${flange ? `?${asked}` : ""}`);
}
