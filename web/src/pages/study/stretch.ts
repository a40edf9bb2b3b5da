/** An axis from 0 to 1; where most values lie close to zero, logarithmic away from it: what they show lies there, too. */

import { significant } from "../../parts/digits";
import { ticks, tickWords } from "../../plots/ticks";

const CROWDED = 0.15; // median distance from zero, as a share of the largest
const SEEN = 1e-4; // of the largest: what is drawn linearly about zero

type Axis = { place: (value: number) => number; ticks: { value: number; text: string }[]; stretched: boolean };

export function spread(values: number[]): Axis {
  const [low, high] = [Math.min(...values), Math.max(...values)];
  const sizes = values.map(Math.abs).sort((one, two) => one - two);
  const largest = sizes.at(-1) ?? 0;
  const crowded = sizes.length >= 5 && largest > 0 && quantile(sizes, 0.5) <= CROWDED * largest;
  if (!crowded) {
    const found = ticks(low, high, 8);
    return {
      place: (value) => (high > low ? (value - low) / (high - low) : 0.5),
      ticks: found.map((value, k) => ({ value, text: tickWords(found)[k] ?? "" })),
      stretched: false,
    };
  }
  const inner = 10 ** Math.floor(Math.log10(Math.max(quantile(sizes, 0.25), SEEN * largest)));
  const bent = (value: number) =>
    Math.abs(value) <= inner ? (0.6 * value) / inner : Math.sign(value) * (0.6 + Math.log10(Math.abs(value) / inner));
  const decades = Array.from({ length: Math.floor(Math.log10(largest / inner)) + 1 }, (_, k) => inner * 10 ** k);
  const found = [...decades.map((each) => -each).reverse(), 0, ...decades].filter((each) => each >= low && each <= high);
  return {
    place: (value) => (bent(value) - bent(low)) / (bent(high) - bent(low)),
    ticks: found.map((value) => ({ value, text: significant(value, 1) })),
    stretched: true,
  };
}

function quantile(sorted: number[], share: number): number {
  const place = share * (sorted.length - 1);
  const [below, above] = [sorted[Math.floor(place)] ?? 0, sorted[Math.ceil(place)] ?? 0];
  return below + (place - Math.floor(place)) * (above - below);
}
