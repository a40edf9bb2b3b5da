/** The jobs of a study: its list, one of them as it goes on, and what can be done with it. */

import { useMutation, useQuery, useQueryClient } from "@tanstack/react-query";
import { useEffect, useState } from "react";

import { answer, api, type Schemas } from "../../api/client";
import { isActive } from "../../api/studies";
import { address } from "../../app/base";

export type Job = Schemas["JobOut"];

const LISTED = 100;
const ASK_MS = 2_000;
const ASK_IDLE_MS = 20_000;

export function useJobs(studyId: string) {
  return useQuery({
    queryKey: ["jobs", studyId],
    queryFn: ({ signal }) =>
      answer(api.GET("/api/v1/jobs", { params: { query: { study_id: studyId, limit: LISTED } }, signal })),
    refetchInterval: ({ state }) => (state.data?.items.some((job) => isActive(job.state)) ? ASK_MS : ASK_IDLE_MS),
  });
}

/** The job with its log, told of each change by the service; while that is silent, the page asks. */
export function useJob(jobId: string) {
  const cache = useQueryClient();
  const [told, setTold] = useState(false);
  const found = useQuery({
    queryKey: ["job", jobId],
    queryFn: ({ signal }) =>
      answer(api.GET("/api/v1/jobs/{job_id}", { params: { path: { job_id: jobId } }, signal })),
    refetchInterval: ({ state }) => (isActive(state.data?.state) && !told ? ASK_MS : false),
  });
  const active = isActive(found.data?.state);
  useEffect(() => {
    if (!active) return;
    const events = new EventSource(address(`api/v1/jobs/${jobId}/events`));
    events.addEventListener("open", () => setTold(true));
    events.addEventListener("error", () => setTold(false));
    events.addEventListener("job", (event) => {
      const now = JSON.parse((event as MessageEvent<string>).data) as Job;
      cache.setQueryData<Job>(["job", jobId], (before) => ({ ...now, log: now.log ?? before?.log ?? null }));
      if (isActive(now.state)) return;
      events.close();
      for (const key of [["job", jobId], ["jobs"], ["studies"], ["payloads"]]) void cache.invalidateQueries({ queryKey: key });
    });
    return () => {
      events.close();
      setTold(false);
    };
  }, [jobId, active, cache]);
  return found;
}

export function useCancel(jobId: string) {
  const cache = useQueryClient();
  return useMutation({
    mutationFn: () =>
      answer(api.POST("/api/v1/jobs/{job_id}/cancel", { params: { path: { job_id: jobId } } })),
    onSuccess: () => cache.invalidateQueries({ queryKey: ["job", jobId] }),
  });
}

export function useRetry(jobId: string) {
  const cache = useQueryClient();
  return useMutation({
    mutationFn: () => answer(api.POST("/api/v1/jobs/{job_id}/retry", { params: { path: { job_id: jobId } } })),
    onSuccess: async () => {
      await cache.invalidateQueries({ queryKey: ["jobs"] });
      await cache.invalidateQueries({ queryKey: ["studies"] });
      await cache.invalidateQueries({ queryKey: ["payloads"] });
    },
  });
}
