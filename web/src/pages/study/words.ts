/** Names of the service's identifiers, in a person's words. */

import type { Place } from "./results";

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
  joint_force: "Force of sliding joints",
  sensor_force: "Forces of the sensors",
  sensor_moment: "Moments of the sensors",
};

/** `tau.torso_pitch` -> `torso_pitch`, `base.my` -> `base moment y`, `ft.wrist.fx` -> `wrist.fx`. */
export function channelWords(channel: string): string {
  const base = /^base\.([fm])([xyz])$/.exec(channel);
  if (base) return `base ${base[1] === "f" ? "force" : "moment"} ${base[2]}`;
  const support = /^support\.(.+)$/.exec(channel);
  if (support) return `${support[1]} (support)`;
  return channel.replace(/^(tau|ft)\./, "");
}

/** Kind, name and part: `{sensor: "wrist", axis: "fx"}`, `{base: true}`. */
function placeOf(where: Place): { kind: string; name: string; part: string } {
  const [kind, name] = Object.entries(where).find(([key]) => key !== "axis") ?? ["", ""];
  return { kind, name: name === true ? kind : String(name), part: String(where.axis ?? "") };
}

/** As the steps of a chain name a place: `torso_pitch`, `wrist.fx`, `base`. */
export function pointOf(where: Place): string {
  const { name, part } = placeOf(where);
  return part ? `${name}.${part}` : name;
}

/** `Stribeck friction at torso_pitch`, of the base the effect alone; as the service says it, else from the identifiers. */
export function titleOf({ title, effect, where }: { title?: string | null; effect: string; where: Place }): string {
  if (title) return capital(title);
  const words = effect.replaceAll("_", " ");
  const { kind, name, part } = placeOf(where);
  if (!kind || kind === "base") return capital(words);
  const place = part ? pointOf(where) : name === "all" ? `every ${kind}` : kind === "joint" || kind === "link" ? name : `${kind} ${name}`;
  return capital(`${words} at ${place}`);
}

export function capital(text: string): string {
  return text.slice(0, 1).toUpperCase() + text.slice(1);
}

/** Within a sentence. Names keep their capital: Stribeck, Coulomb. */
export function lower(title: string): string {
  return /^(Stribeck|Coulomb)/.test(title) ? title : title.slice(0, 1).toLowerCase() + title.slice(1);
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
