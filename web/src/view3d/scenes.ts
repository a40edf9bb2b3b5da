import { useQuery } from "@tanstack/react-query";

import { answer, api, type Schemas } from "../api/client";

export type Scene = Schemas["SceneOut"];

/** The logs of a job that can be looked at. */
export function useScenes(jobId: string) {
  return useQuery({
    queryKey: ["jobs", jobId, "scenes"],
    queryFn: ({ signal }) => answer(api.GET("/api/v1/jobs/{job_id}/scenes", { params: { path: { job_id: jobId } }, signal })),
  });
}

/** One log drawn, as the player takes it. The first one who asks waits a few seconds. */
export function useRecording(jobId: string, log: string) {
  return useQuery({
    queryKey: ["jobs", jobId, "scenes", log],
    queryFn: async ({ signal }) => {
      const path = { job_id: jobId, name: log };
      const asked = api.GET("/api/v1/jobs/{job_id}/scenes/{name}.scene", { params: { path }, parseAs: "arrayBuffer", signal });
      return answer<ArrayBuffer>(asked as Promise<{ data?: ArrayBuffer; error?: unknown; response: Response }>);
    },
    staleTime: Infinity,
    gcTime: 60_000,
    retry: false,
  });
}
