/** Round numbers along an axis, and how they are written. */

import { fixed, significant } from "../parts/digits";

const MOST_PLACES = 6; // more are not read at a glance
const SMALLEST = 20; // places; no axis is finer
const NOISE = 1e-3; // of a step, what counts as round: far below the quarter of 2.5

export function ticks(low: number, high: number, wanted: number): number[] {
  if (!(high > low)) return [low];
  const step = roundStep((high - low) / Math.max(wanted, 1));
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k += 1) found.push(k * step);
  return found;
}

/** Exactly the ticks: a step of 0.25 takes two places, not the one that would tell them apart. Past `MOST_PLACES` in powers of ten. */
export function tickWords(found: readonly number[]): string[] {
  const step = found.length > 1 ? Math.abs((found[1] as number) - (found[0] as number)) : Math.abs(found[0] ?? 0);
  const places = placesOf(step);
  if (places <= MOST_PLACES) return found.map((each) => fixed(each, places));
  return found.map((each) => significant(each, Math.max(exponent(each) + places + 1, 1)));
}

/** After the point, until nothing of the step is left; steps are round numbers but for what floating point adds. */
function placesOf(step: number): number {
  for (let places = 0; places < SMALLEST; places += 1) {
    const raised = step * 10 ** places;
    if (Math.abs(raised - Math.round(raised)) <= NOISE * raised) return places;
  }
  return SMALLEST;
}

function exponent(value: number): number {
  return value === 0 ? 0 : Math.floor(Math.log10(Math.abs(value)) + 1e-9);
}

function roundStep(rough: number): number {
  const power = 10 ** Math.floor(Math.log10(rough));
  const factor = [1, 2, 5, 10].find((each) => each * power >= rough * (1 - 1e-9)) ?? 10;
  return factor * power;
}
