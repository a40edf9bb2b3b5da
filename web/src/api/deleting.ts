import { answer, api } from "./client";

export type Deletable = "studies" | "robots" | "devices" | "payloads" | "motions" | "plans";

/** With what hangs on it; a refusal names what needs it. */
export async function deleteOne(kind: Deletable, id: string): Promise<void> {
  const asked = {
    studies: () => api.DELETE("/api/v1/studies/{study_id}", { params: { path: { study_id: id } } }),
    robots: () => api.DELETE("/api/v1/robots/{robot_id}", { params: { path: { robot_id: id } } }),
    devices: () => api.DELETE("/api/v1/devices/{device_id}", { params: { path: { device_id: id } } }),
    motions: () => api.DELETE("/api/v1/motions/{motion_id}", { params: { path: { motion_id: id } } }),
    plans: () => api.DELETE("/api/v1/plans/{plan_id}", { params: { path: { plan_id: id } } }),
    payloads: () => api.DELETE("/api/v1/payloads/{payload_id}", { params: { path: { payload_id: id } } }),
  }[kind];
  await answer<unknown>(asked());
}
