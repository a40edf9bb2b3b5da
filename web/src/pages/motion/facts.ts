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
  rate: "Rate",
  decimals: "Decimals",
  rate_doubt: "Doubt of the rate",
  exchanged: "Labels exchanged",
  slips: "Markers that slipped",
  strays: "Doubt of markers",
  held: "Values held",
  joined: "Takes joined",
  leaps: "Leaps",
  residual: "What is left",
  scales: "Lengths, of a body of 1.75 m",
  fits_badly: "Fits badly",
  elsewhere: "Sits elsewhere",
  scale_at_bound: "Length at its bound",
  not_tracked: "Not tracked",
  few_points: "Few points",
  guessed: "Guessed",
  not_settled: "Not settled",
  "may touch": "May touch, and are not looked at",
  "touch as hulls": "Near as hulls alone, and not looked at",
};

/** Whatever was told has words: what is new on the service is not kept from whoever looks. */
export function toldWords(key: string): string {
  return TOLD[key] ?? `${key.slice(0, 1).toUpperCase()}${key.slice(1).replaceAll("_", " ")}`;
}

/** Parts of the body, in words. */
export function partWords(segment: string): string {
  const [side, ...rest] = segment.split("_");
  const sides: Record<string, string> = { l: "left", r: "right" };
  return side && sides[side] ? `${sides[side]} ${rest.join(" ")}` : segment;
}
