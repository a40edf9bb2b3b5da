/** Where a fault of the draft belongs: to a key of payload.yaml, and so to a step and a field; or to a file. */

import type { Verdict } from "../../../api/payloadDrafts";
import type { Content, Role } from "./content";

export type Fault = Verdict["errors"][number];
export const STEPS = ["sensor", "workspace", "postures", "excitation", "result"] as const;
export type Step = (typeof STEPS)[number];

const MAIN = "payload.yaml";
const OPEN = ["missing", "string_too_short", "string_type", "float_type", "finite_number"];
const STEP_OF: Record<Role, Step> = { postures: "postures", excitation: "excitation", test: "result", contact: "result" };

/** Rules of the whole file are told without a key; the one on gravity belongs to its field. */
export function placed(fault: Fault): Fault {
  return !fault.column && fault.detail.startsWith("gravity ") ? { ...fault, column: "gravity" } : fault;
}

/** Nothing wrong: it is only not said yet. */
export function isOpen(fault: Fault): boolean {
  return OPEN.includes(fault.code);
}

export function stepOf(fault: Fault, content: Content): Step {
  const { file, column } = fault;
  if (file && file !== MAIN) {
    const log = content.logs.find((each) => each.file.includes(file));
    return log && !/column|unit|axes|angle|rotation|quaternion/.test(fault.code) ? STEP_OF[log.role] : "sensor";
  }
  const key = column ?? "";
  if (key.startsWith("plan.postures")) return "postures";
  if (key.startsWith("plan.excitation")) return "excitation";
  if (key.startsWith("plan")) return "workspace";
  const log = /^logs\.(\d+)/.exec(key);
  if (log) return STEP_OF[content.logs[Number(log[1])]?.role ?? "test"];
  return key && !key.startsWith("ground_truth") && !key.startsWith("settings") ? "sensor" : "result";
}

/** What a field says of its own fault; what is only open, once `tried`. */
export function saysOf(faults: readonly Fault[], tried: boolean) {
  return (key: string): string | undefined => {
    const mine = faults.filter(({ file, column }) => (!file || file === MAIN) && column === key);
    const told = mine.filter((fault) => tried || !isOpen(fault));
    if (told.length === 0) return undefined;
    return told.map((fault) => (isOpen(fault) ? "Not said yet." : wordsOf(fault))).join(" ");
  };
}

export function wordsOf({ detail, advice, value }: Fault): string {
  const shown = value ? ` (${value})` : "";
  return `${detail}${shown}.${advice ? ` ${advice.slice(0, 1).toUpperCase()}${advice.slice(1)}` : ""}`;
}

/** `sensor.noise.force_n`: as the field is called. */
export function fieldOf(column: string | null | undefined): string {
  const known = Object.entries(FIELDS).find(([key]) => column === key || column?.startsWith(`${key}.`));
  return known?.[1] ?? column ?? "";
}

const FIELDS: Record<string, string> = {
  name: "its name",
  gravity: "gravity",
  "sensor.frame": "the sensor’s frame",
  "sensor.noise.force_n": "the noise of a force",
  "sensor.noise.moment_nm": "the noise of a moment",
  "sensor.noise": "the noise of force and moment",
  "sensor.wrench": "the columns of the wrench",
  "sensor.range": "the rated range",
  "pose.noise_rad": "the noise of an angle",
  "pose.noise_m": "the noise of the position",
  "pose.joints": "the columns of the joints",
  "pose.rotation": "the columns of the rotation",
  "pose.quaternion": "the columns of the quaternion",
  pose: "the pose (a URDF, or columns of a rotation)",
  "plan.payload.mass_kg": "the believed mass",
  "plan.payload.centre_m": "the believed centre of mass",
  "plan.payload.size_m": "the size of the payload",
  "plan.payload": "what is believed of the payload",
  "plan.home": "home",
  "plan.acceleration": "accelerations",
  "plan.joints": "joints that move",
  "plan.workspace": "the workspace",
};
