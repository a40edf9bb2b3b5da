/** Round numbers along an axis, and how they are written. */

import { fixed } from "../parts/digits";

export function ticks(low: number, high: number, wanted: number): number[] {
  if (!(high > low)) return [low];
  const step = roundStep((high - low) / Math.max(wanted, 1));
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k += 1) found.push(k * step);
  return found;
}

/** As many places as tell the ticks apart. */
export function tickWords(found: readonly number[]): string[] {
  const step = found.length > 1 ? Math.abs((found[1] as number) - (found[0] as number)) : 1;
  const places = Math.min(Math.max(0, -Math.floor(Math.log10(step || 1) + 1e-9)), 9);
  return found.map((each) => fixed(each, places));
}

function roundStep(rough: number): number {
  const power = 10 ** Math.floor(Math.log10(rough));
  const factor = [1, 2, 5, 10].find((each) => each * power >= rough * (1 - 1e-9)) ?? 10;
  return factor * power;
}
