/** `scope` and `configuration` of results.json: for what the results hold, and with what they were obtained. */

import type { Schemas } from "../../api/client";
import { fixed, significant } from "../../parts/digits";
import type { Num } from "./results";

export type Reach = Schemas["Reach"];
export type Scope = Schemas["Scope"];
export type StatedBand = Schemas["StatedBand"];
export type Configuration = Schemas["Configuration"];
export type Told = Configuration["conditions"];

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
