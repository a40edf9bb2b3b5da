/** Names of the service's identifiers, in a person's words. */

import type { Candidate, Finding } from "./results";

export const STEPS: Record<string, [string, string]> = {
  identify: ["Identification", "masses, motors, friction of the robot"],
  discrepancy: ["Missing effects", "what the model lacks"],
  support: ["Supporting torque", "joint by joint, A and B"],
  stiffness: ["Bands", "stiffness and natural length"],
};

export const KINDS: Record<string, string> = {
  evaluate: "whole evaluation",
  support: "up to the supporting torque",
  stiffness: "up to the bands",
  whatif: "another device",
};

export const POOLED: Record<string, string> = {
  base_moment: "Base moment",
  trunk_torque: "Torque of the trunk’s joints",
  joint_torque: "Torque of all joints",
};

/** `tau.torso_pitch` -> `torso_pitch`, `base.my` -> `base moment y`. */
export function channelWords(channel: string): string {
  const base = /^base\.([fm])([xyz])$/.exec(channel);
  if (base) return `base ${base[1] === "f" ? "force" : "moment"} ${base[2]}`;
  return channel.replace(/^tau\./, "");
}

/** `Stribeck friction at torso_pitch`, as the service says it, else from the identifiers. */
export function titleOf({ title, effect, where }: Pick<Candidate | Finding, "title" | "effect" | "where">): string {
  const [kind = "", name = ""] = Object.entries(where)[0] ?? [];
  const place = name === "all" ? `every ${kind}` : kind === "joint" || kind === "link" ? name : `${kind} ${name}`.trim();
  return capital(title ?? `${effect.replaceAll("_", " ")} at ${place}`);
}

export function capital(text: string): string {
  return text.slice(0, 1).toUpperCase() + text.slice(1);
}

/** True arrows and minus signs, and no line break between a number and its unit. */
export function typeset(text: string): string {
  return text
    .replaceAll("->", "→")
    .replace(/(?<![^\s(±])-(?=\d)/g, "−")
    .replace(/(?<=\d) (?=%|±|[Nmk]·?[mg/]|rad|°|s\b)|(?<=±) (?=\d)/g, "\u00a0");
}

export function duration(seconds: number): string {
  const whole = Math.max(Math.round(seconds), 0);
  if (whole < 60) return `${whole} s`;
  if (whole < 3600) return `${Math.floor(whole / 60)} min ${whole % 60} s`;
  return `${Math.floor(whole / 3600)} h ${Math.floor((whole % 3600) / 60)} min`;
}
