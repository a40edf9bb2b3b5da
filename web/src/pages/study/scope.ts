/** `scope` and `configuration` of results.json: for what the results hold, and with what they were obtained. */

import { fixed, significant } from "../../parts/digits";
import type { Num } from "./results";

export type Reach = { joint: string; moved: boolean; lowest: Num; highest: Num; top_speed: Num; unit: "rad" | "m" };

export type Scope = {
  sentence: string;
  synthetic: boolean;
  robot: string;
  devices: string[];
  identified: Reach[];
  not_moved: string[];
  motions: { device: string; motion: string; logs: string[]; joints: (Reach & { main: boolean })[] }[];
  not_said: string[];
};

export type StatedBand = {
  band: string;
  group: string;
  via_points: { link: string; xyz: number[] }[];
  stiffness_n_per_m: Num;
  natural_length_m: Num;
  ground_truth: boolean;
  law: string;
};

export type Told = Record<string, string | null>;

export type Configuration = {
  synthetic: string[];
  conditions: Told;
  robot: { name: string; base: string; moving_links: number; joints: { joint: string; actuation: string }[]; sensors: { name: string; role: string }[] };
  devices: { device: string; file: string; logs: string[]; record: Told; bands: StatedBand[] }[];
  logs: { log: string; role: string; motion: string | null; device: string | null; duration_s: Num; rate_hz: Num }[];
  settings: Record<string, unknown>;
  inputs_sha256: string;
};

const DEGREES = 180 / Math.PI;

/** `−2.1 … 61.0°` */
export function range({ lowest, highest, unit }: Reach): string {
  if (unit === "m") return `${significant(lowest)} … ${significant(highest)} m`;
  return `${fixed(inDegrees(lowest), 1)} … ${fixed(inDegrees(highest), 1)}°`;
}

/** `48°/s` */
export function speed({ top_speed, unit }: Reach): string {
  return unit === "m" ? `${significant(top_speed)} m/s` : `${significant(inDegrees(top_speed), 2)}°/s`;
}

function inDegrees(angle: Num): Num {
  return angle === null ? null : angle * DEGREES;
}

/** The links that a band runs over, in order. */
export function route({ via_points }: StatedBand): string {
  return [...new Set(via_points.map((point) => point.link))].join(" – ");
}
