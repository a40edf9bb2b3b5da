import { useQuery } from "@tanstack/react-query";

import { answer, api, type Schemas, whole } from "../api/client";

export type Scene = Schemas["SceneOut"];

/** The logs of a job that can be looked at. */
export function useScenes(jobId: string) {
  return useQuery({
    queryKey: ["jobs", jobId, "scenes"],
    queryFn: ({ signal }) =>
      whole((query) => answer(api.GET("/api/v1/jobs/{job_id}/scenes", { params: { path: { job_id: jobId }, query }, signal }))),
  });
}

type Packed = Promise<{ data?: ArrayBuffer; error?: unknown; response: Response }>;

const KEPT = { staleTime: Infinity, gcTime: 60_000, retry: false } as const;

/** One log drawn, as the player takes it. The first one who asks waits a few seconds. */
export function useRecording(jobId: string, log: string) {
  return useQuery({
    queryKey: ["jobs", jobId, "scenes", log],
    queryFn: ({ signal }) => {
      const params = { path: { job_id: jobId, name: log } };
      return answer(api.GET("/api/v1/jobs/{job_id}/scenes/{name}.scene", { params, parseAs: "arrayBuffer", signal }) as Packed);
    },
    ...KEPT,
  });
}

/** A robot at rest. */
export function useRobotScene(robotId: string) {
  return useQuery({
    queryKey: ["robots", robotId, "scene"],
    queryFn: ({ signal }) => {
      const params = { path: { robot_id: robotId } };
      return answer(api.GET("/api/v1/robots/{robot_id}/scene", { params, parseAs: "arrayBuffer", signal }) as Packed);
    },
    ...KEPT,
  });
}

/** A payload on its robot at home. about: what the drawing depends on. */
export function usePayloadScene(payloadId: string, about: string) {
  return useQuery({
    queryKey: ["payloads", payloadId, "scene", about],
    queryFn: ({ signal }) => {
      const params = { path: { payload_id: payloadId } };
      return answer(api.GET("/api/v1/payloads/{payload_id}/scene", { params, parseAs: "arrayBuffer", signal }) as Packed);
    },
    ...KEPT,
  });
}

/** What is planned, on its robot beside the person. */
export function usePlanScene(planId: string, jobId: string) {
  return useQuery({
    queryKey: ["plans", planId, "scene", jobId],
    queryFn: ({ signal }) => {
      const params = { path: { plan_id: planId } };
      return answer(api.GET("/api/v1/plans/{plan_id}/scene", { params, parseAs: "arrayBuffer", signal }) as Packed);
    },
    ...KEPT,
  });
}

/** The person as it was captured. about: what the drawing depends on. */
export function useMotionScene(motionId: string, about: string) {
  return useQuery({
    queryKey: ["motions", motionId, "scene", about],
    queryFn: ({ signal }) => {
      const params = { path: { motion_id: motionId } };
      return answer(api.GET("/api/v1/motions/{motion_id}/scene", { params, parseAs: "arrayBuffer", signal }) as Packed);
    },
    ...KEPT,
  });
}

/** A device on its robot at rest, whose via points can be dragged. */
export function useDeviceScene(deviceId: string) {
  return useQuery({
    queryKey: ["devices", deviceId, "scene"],
    queryFn: ({ signal }) => {
      const params = { path: { device_id: deviceId } };
      return answer(api.GET("/api/v1/devices/{device_id}/scene", { params, parseAs: "arrayBuffer", signal }) as Packed);
    },
    ...KEPT,
  });
}
