/** What was captured of people, and what is planned of it for robots: lists, one of them, contacts, names, plans. */

import { keepPreviousData, useInfiniteQuery, useMutation, useQuery, useQueryClient } from "@tanstack/react-query";

import { address } from "../app/base";
import { answer, api, type Schemas, whole } from "./client";
import { bundle } from "./robots";
import { isActive } from "./studies";

export type Label = { name: string; segment: string | null; gaps: number };
export type MotionSummary = {
  frames: number;
  rate_hz: number;
  seconds: number;
  holds: "markers" | "skeleton" | "angles";
  static: boolean;
  labels?: Label[];
  told: Record<string, string | number>;
};
export type Motion = Omit<Schemas["MotionOut"], "summary"> & { summary: MotionSummary };
export type Contacts = Schemas["ContactsOut"];
export type Feet = Schemas["ContactsEntry"];
export type Plan = Schemas["MotionPlanOut"];
export type Found = Schemas["PlanFound"];
export type PlanAsked = Schemas["PlanAsked"];
export type Restated = Schemas["Restated"];

const PAGE = 100;
const BUSY_MS = 1_000;
const IDLE_MS = 20_000;

/** Newest first; each version is one of them. */
export function useMotions(search = "") {
  return useInfiniteQuery({
    queryKey: ["motions", { search }],
    placeholderData: keepPreviousData,
    queryFn: ({ pageParam, signal }) => {
      const query = { limit: PAGE, cursor: pageParam, search: search || undefined };
      return answer(api.GET("/api/v1/motions", { params: { query }, signal }));
    },
    initialPageParam: undefined as string | undefined,
    getNextPageParam: (page) => page.next_cursor ?? undefined,
    select: ({ pages }) => pages.flatMap((page) => page.items) as Motion[],
  });
}

export function useMotion(id: string) {
  return useQuery({
    queryKey: ["motions", id],
    queryFn: ({ signal }) =>
      answer(api.GET("/api/v1/motions/{motion_id}", { params: { path: { motion_id: id } }, signal })) as Promise<Motion>,
    refetchInterval: ({ state }) => (isActive(state.data?.latest_job?.state) ? BUSY_MS : IDLE_MS),
  });
}

/** said: up, unit, angle, static, map, where the file is silent or wrong. */
export function useAddMotion() {
  const cache = useQueryClient();
  return useMutation({
    mutationFn: ({ files, said }: { files: Map<string, Blob>; said: Record<string, string> }) =>
      answer(api.POST("/api/v1/motions", { body: bundle(files, said) as never, bodySerializer: (form) => form })) as Promise<Motion>,
    onSuccess: () => cache.invalidateQueries({ queryKey: ["motions"] }),
  });
}

/** The same files read otherwise: another version. */
export function useRestate(id: string) {
  const cache = useQueryClient();
  return useMutation({
    mutationFn: (body: Restated) =>
      answer(api.POST("/api/v1/motions/{motion_id}/versions", { params: { path: { motion_id: id } }, body })) as Promise<Motion>,
    onSuccess: () => cache.invalidateQueries({ queryKey: ["motions"] }),
  });
}

export function useContacts(id: string) {
  return useQuery({
    queryKey: ["motions", id, "contacts"],
    queryFn: ({ signal }) => answer(api.GET("/api/v1/motions/{motion_id}/contacts", { params: { path: { motion_id: id } }, signal })),
  });
}

/** null: as they were read. */
export function useSayContacts(id: string) {
  const cache = useQueryClient();
  return useMutation({
    mutationFn: (said: Feet | null) => {
      const params = { path: { motion_id: id } };
      return answer(
        said ? api.PUT("/api/v1/motions/{motion_id}/contacts", { params, body: said }) : api.DELETE("/api/v1/motions/{motion_id}/contacts", { params }),
      );
    },
    onSuccess: (now) => cache.setQueryData(["motions", id, "contacts"], now),
  });
}

export function useMaps() {
  return useQuery({
    queryKey: ["motion-maps"],
    queryFn: ({ signal }) => whole((query) => answer(api.GET("/api/v1/motion-maps", { params: { query }, signal }))),
  });
}

/** Names that are kept for the next capture, and taken for this one. */
export function useKeepMap() {
  const cache = useQueryClient();
  return useMutation({
    mutationFn: (body: Schemas["MapIn"]) => answer(api.POST("/api/v1/motion-maps", { body })),
    onSuccess: () => cache.invalidateQueries({ queryKey: ["motion-maps"] }),
  });
}

export function useFit(id: string) {
  const cache = useQueryClient();
  return useMutation({
    mutationFn: () => answer(api.POST("/api/v1/jobs", { body: { motion_id: id, kind: "human_fit", settings: {} } })),
    onSuccess: () => cache.invalidateQueries({ queryKey: ["motions", id] }),
  });
}

/** Newest first; those made of one motion, where given. */
export function useMotionPlans(of: { motion_id?: string } = {}) {
  return useInfiniteQuery({
    queryKey: ["plans", of],
    queryFn: ({ pageParam, signal }) =>
      answer(api.GET("/api/v1/plans", { params: { query: { limit: PAGE, cursor: pageParam, ...of } }, signal })),
    initialPageParam: undefined as string | undefined,
    getNextPageParam: (page) => page.next_cursor ?? undefined,
    select: ({ pages }) => pages.flatMap((page) => page.items) as Plan[],
    refetchInterval: ({ state }) => {
      const all = state.data?.pages.flatMap((page) => page.items) ?? [];
      return all.some((plan) => isActive(plan.latest_job?.state)) ? BUSY_MS : IDLE_MS;
    },
  });
}

export function usePlan(id: string) {
  return useQuery({
    queryKey: ["plans", id],
    queryFn: ({ signal }) => answer(api.GET("/api/v1/plans/{plan_id}", { params: { path: { plan_id: id } }, signal })) as Promise<Plan>,
    refetchInterval: ({ state }) => (isActive(state.data?.latest_job?.state) ? BUSY_MS : IDLE_MS),
  });
}

export function useCreatePlan() {
  const cache = useQueryClient();
  return useMutation({
    mutationFn: (body: PlanAsked) => answer(api.POST("/api/v1/plans", { body })) as Promise<Plan>,
    onSuccess: () => cache.invalidateQueries({ queryKey: ["plans"] }),
  });
}

/** Studies that hold the motion of a plan, byte for byte. */
export function useStudiesOfPlan(id: string, ready: boolean) {
  return useQuery({
    queryKey: ["plans", id, "studies"],
    queryFn: ({ signal }) => answer(api.GET("/api/v1/studies", { params: { query: { plan_id: id } }, signal })),
    enabled: ready,
  });
}

export function planExport(id: string, format: string, rateHz: number | undefined, despite: boolean): string {
  const asked = new URLSearchParams();
  if (rateHz) asked.set("rate_hz", String(rateHz));
  if (despite) asked.set("despite", "true");
  return address(`api/v1/plans/${id}/exports/${format}?${asked}`);
}
