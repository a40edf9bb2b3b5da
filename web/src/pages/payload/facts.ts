/** What a payload's summary says, in a few words. */

import type { Payload } from "../../api/payloads";
import { count } from "../../parts/size";

const ROLES = { postures: "postures", excitation: "excitation", test: "test", contact: "contact" } as const;

export function factsOf({ summary: { sensor, joints, logs, plan, imu } }: Payload): string[] {
  const facts = [];
  facts.push(joints.length ? `sensor ${sensor.frame ?? ""} behind ${count(joints.length, "joint")}` : "logged pose of the sensor");
  const roles = [...new Set(logs.map(({ role }) => ROLES[role]))];
  facts.push(logs.length ? `${count(logs.length, "log")}: ${roles.join(", ")}` : "no logs");
  if (imu) facts.push("with an IMU");
  if (plan) facts.push("with a plan");
  return facts;
}

/** Whether its logs tell anything of it. */
export function identifies({ summary: { logs } }: Payload): boolean {
  return logs.some(({ role }) => role === "postures" || role === "excitation");
}
