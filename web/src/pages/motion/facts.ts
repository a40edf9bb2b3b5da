/** A motion and a plan in a few words. */

import type { Motion, Plan } from "../../api/motions";
import { figure, percent } from "../../parts/digits";

const HOLDS = { markers: "markers", skeleton: "skeleton", angles: "joint angles" } as const;

export function factsOf({ summary }: Motion): string[] {
  return [HOLDS[summary.holds], `${figure(summary.seconds)} s at ${figure(summary.rate_hz)} Hz`, ...(summary.static ? ["with a static trial"] : [])];
}

/** How it was asked for, without what is as usual. */
export function planWords({ kind, request }: Plan): string {
  const asked = request as Record<string, number | boolean | string[] | null>;
  if (kind === "excite") return `a motion of ${figure(asked["seconds"] as number)} s that identifies`;
  const said = ["as the person moved"];
  const [begin, end] = [asked["begin"] as number, asked["end"] as number | null];
  if (begin > 0 || end !== null) said.push(`from ${figure(begin)} s${end === null ? "" : ` to ${figure(end)} s`}`);
  if (asked["slow"] !== 1) said.push(`${figure(asked["slow"] as number)} times the time`);
  if (asked["share"] !== 1) said.push(`${percent(asked["share"] as number)} of the trunk’s angle`);
  if (asked["margin_m"] !== undefined && asked["margin_m"] !== 0.02) said.push(`${figure(1e3 * (asked["margin_m"] as number))} mm of balance`);
  if ((asked["repeat"] as number) > 1) said.push(`${asked["repeat"]} times`);
  if (asked["mirror"]) said.push("left and right exchanged");
  for (const part of (asked["without"] as string[]) ?? []) said.push(`without ${part}`);
  return said.join(", ");
}

/** What was told of a capture, in words: keys as the service names them. */
export const TOLD: Record<string, string> = {
  format: "Format",
  preset: "Names",
  up: "Upwards",
  unit: "Unit of length",
  unit_doubt: "Doubt of the unit",
  sides_doubt: "Doubt of left and right",
  limb_positions: "Limbs that move",
  prefix: "Subject",
  markers: "Markers",
  bones: "Bones",
  coordinates: "Coordinates",
  gaps: "Gaps",
  longest_gap: "Longest gap",
  feet: "Feet",
  unknown: "Of no known part",
  left_out: "Left out",
  measured: "Measured",
  far_away: "Beyond any room",
  duplicates: "Named twice",
  still: "Nothing moves",
  renamed: "Names taken",
  angles: "Angles",
  "not in the file": "Mapped, not there",
};

/** Parts of the body, in words. */
export function partWords(segment: string): string {
  const [side, ...rest] = segment.split("_");
  const sides: Record<string, string> = { l: "left", r: "right" };
  return side && sides[side] ? `${sides[side]} ${rest.join(" ")}` : segment;
}
