/** Plots of captured and planned motions: `human.trunk_flexion`, `trunk.given.torso_pitch`, `margin.nearest_pair`,
`bound.torque`, `marker.LASI.x`. */

import type { RawLine } from "./raw";

/** In what a motion's tables tell it, and how much of that a unit of the file is. Lengths but those of a margin stay. */
export function shownUnit(name: string, unit: string): [unit: string, scale: number] {
  if (unit === "rad") return ["°", 180 / Math.PI];
  if (unit === "m" && name.startsWith("margin.")) return ["mm", 1e3];
  if (name.startsWith("bound.")) return ["%", 1e2];
  return [unit, 1];
}

const MARGINS: Record<string, string> = {
  pressure_inside: "Centre of pressure inside what the feet stand on",
  nearest_pair: "Distance of the nearest pair",
  weight_carried: "Share of the weight on the feet",
};
const TRUNK: Record<string, string> = { trunk_flexion: "flexion ahead", trunk_bend: "bend to the right", trunk_rotation: "rotation to the left" };
const PLACED: Record<string, string> = { marker: "Marker", bone: "Bone" };

/** null: of no kind that motions have. */
export function motionLine(name: string): RawLine | null {
  const [kind = "", ...parts] = name.split(".");
  const rest = parts.join(".");
  switch (kind) {
    case "human":
      return { key: "human", title: "Trunk of the person", group: "Trunk", words: TRUNK[rest] ?? rest };
    case "trunk": {
      const joint = parts.slice(1).join(".");
      return { key: `trunk.${joint}`, title: `Trunk at ${joint}`, group: "Trunk", words: parts[0] === "asked" ? "asked" : "given" };
    }
    case "margin":
      return { key: name, title: MARGINS[rest] ?? rest, group: "Margins", words: "planned" };
    case "bound":
      return { key: "bounds", title: "Largest share of each bound", group: "Shares of bounds", words: rest };
    case "pressure":
      return { key: "pressure", title: "Centre of pressure", group: "Margins", words: rest };
    case "marker":
    case "bone": {
      const label = parts.slice(0, -1).join(".");
      return { key: `${kind}.${label}`, title: `${PLACED[kind]} ${label}`, group: "Person", words: parts.at(-1) ?? "" };
    }
    case "angle":
      return { key: name, title: rest.replaceAll("_", " "), group: "Person", words: "angle" };
    default:
      return null;
  }
}
