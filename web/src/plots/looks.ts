/** How a line looks, in light and in dark: never told apart by colour alone, and each at least 3 : 1 against its ground. */

import type { Look } from "./channels";

export type Scheme = "light" | "dark";

type Pen = { colour: Record<Scheme, string>; width: number; dash?: number[] };

const PENS: Record<Look, Pen> = {
  measured: { colour: { light: "#7b868c", dark: "#9aa6ad" }, width: 3 },
  predicted: { colour: { light: "#0b5a6f", dark: "#79cfe6" }, width: 1.5 },
  prior: { colour: { light: "#a85400", dark: "#ffb36b" }, width: 1.5, dash: [2, 4] },
  support_a: { colour: { light: "#1d5fc4", dark: "#8db9ff" }, width: 2 },
  support_b: { colour: { light: "#a8195f", dark: "#ff9cc9" }, width: 2, dash: [9, 3] },
  support_paired: { colour: { light: "#2b7a3d", dark: "#86d99a" }, width: 2, dash: [4, 2] },
  band_model: { colour: { light: "#1b2327", dark: "#eef3f5" }, width: 1.5, dash: [6, 3, 1.5, 3] },
  other0: { colour: { light: "#1d5fc4", dark: "#8db9ff" }, width: 2 },
  other1: { colour: { light: "#a8195f", dark: "#ff9cc9" }, width: 2, dash: [9, 3] },
  other2: { colour: { light: "#2b7a3d", dark: "#86d99a" }, width: 2, dash: [2, 4] },
  other3: { colour: { light: "#a85400", dark: "#ffb36b" }, width: 2, dash: [6, 3, 1.5, 3] },
  other4: { colour: { light: "#6a3fb5", dark: "#c5a8ff" }, width: 2, dash: [12, 4] },
  other5: { colour: { light: "#4d5a61", dark: "#b8c4ca" }, width: 2, dash: [4, 2] },
};

const GROUND: Record<Scheme, { ink: string; quiet: string; grid: string; paper: string; cursor: string }> = {
  light: { ink: "#1b2327", quiet: "#4f5b61", grid: "#e3e8ea", paper: "#ffffff", cursor: "#b02020" },
  dark: { ink: "#e8eef0", quiet: "#b3bdc2", grid: "#3a4247", paper: "#242424", cursor: "#ffa8a0" },
};

export type Drawn = { colour: string; width: number; dash?: number[] };

export function pen(look: Look, scheme: Scheme): Drawn {
  const { colour, ...rest } = PENS[look];
  return { colour: colour[scheme], ...rest };
}

export function ground(scheme: Scheme) {
  return GROUND[scheme];
}

/** The shade of an uncertainty behind its line. */
export function shade(look: Look, scheme: Scheme): string {
  return `${PENS[look].colour[scheme]}2e`;
}
