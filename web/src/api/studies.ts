import { keepPreviousData, useInfiniteQuery, useMutation, useQuery, useQueryClient } from "@tanstack/react-query";
import { useEffect, useMemo } from "react";

import { answer, api, type Schemas } from "./client";

export type Study = Schemas["StudyOut"];
export type LatestJob = Schemas["LatestJob"];
export type JobState = LatestJob["state"];
export type StateSought = JobState | "none";

const PAGE = 30;
const LONGEST_PAGE = 200;
const BUSY_MS = 2_000;
const IDLE_MS = 20_000;

export function isActive(state: JobState | undefined): boolean {
  return state === "queued" || state === "running";
}

/** Newest first, page by page; asked again while something runs. Of those with the words and the state, where given. */
export function useStudies(search = "", state: StateSought | "" = "") {
  const sought = { search: search || undefined, state: state || undefined };
  return useInfiniteQuery({
    queryKey: ["studies", sought],
    placeholderData: keepPreviousData,
    queryFn: ({ pageParam, signal }) =>
      answer(api.GET("/api/v1/studies", { params: { query: { limit: PAGE, cursor: pageParam, ...sought } }, signal })),
    initialPageParam: undefined as string | undefined,
    getNextPageParam: (page) => page.next_cursor ?? undefined,
    refetchInterval: ({ state }) => {
      const all = state.data?.pages.flatMap((page) => page.items) ?? [];
      return all.some((study) => isActive(study.latest_job?.state)) ? BUSY_MS : IDLE_MS;
    },
  });
}

/** Every study of the kind, however many pages that takes. robot_id: of a robot by its files; `none`: of one that is in no list. */
export function useEveryStudy(of: { robot_id?: string; state?: StateSought } = {}) {
  const found = useInfiniteQuery({
    queryKey: ["studies", "every", of],
    queryFn: ({ pageParam, signal }) =>
      answer(api.GET("/api/v1/studies", { params: { query: { limit: LONGEST_PAGE, cursor: pageParam, ...of } }, signal })),
    initialPageParam: undefined as string | undefined,
    getNextPageParam: (page) => page.next_cursor ?? undefined,
  });
  const { hasNextPage, error, isFetchingNextPage, fetchNextPage } = found;
  useEffect(() => {
    if (hasNextPage && !error && !isFetchingNextPage) void fetchNextPage();
  }, [hasNextPage, error, isFetchingNextPage, fetchNextPage]);
  return { ...found, studies: useMemo(() => found.data?.pages.flatMap((page) => page.items) ?? [], [found.data]) };
}

export function useStudy(id: string) {
  return useQuery({
    queryKey: ["studies", id],
    queryFn: ({ signal }) =>
      answer(api.GET("/api/v1/studies/{study_id}", { params: { path: { study_id: id } }, signal })),
    refetchInterval: ({ state }) => (isActive(state.data?.latest_job?.state) ? BUSY_MS : IDLE_MS),
  });
}

/** Start an evaluation; an equal one that is there already is its answer. */
export function useSubmitJob() {
  const cache = useQueryClient();
  return useMutation({
    mutationFn: (wanted: Schemas["JobRequest"]) => answer(api.POST("/api/v1/jobs", { body: wanted })),
    onSuccess: () => cache.invalidateQueries({ queryKey: ["studies"] }),
  });
}
