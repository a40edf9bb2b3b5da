/** Curves of several recordings on one axis of time, each from its own start. */

import type { TimeLine } from "../../parts/TimePlot";

export type Curve = { name: string; look: number; old: boolean; t: number[]; min: (number | null)[]; max: (number | null)[] };

/** Each stretch as its smallest and then its largest value, so that no peak is lost. */
export function laidOver(curves: Curve[]): { t: number[]; lines: TimeLine[] } {
  const own = curves.map((curve) => points(curve));
  const t = [...new Set(own.flatMap((each) => each.t))].sort((a, b) => a - b);
  const place = new Map(t.map((time, k) => [time, k]));
  const lines = curves.map((curve, k) => {
    const values: (number | null | undefined)[] = new Array(t.length).fill(undefined); // not null: the line goes on between
    own[k]?.t.forEach((time, j) => {
      values[place.get(time) ?? 0] = own[k]?.values[j] ?? null;
    });
    return { name: curve.name, look: curve.look, old: curve.old, values: values as (number | null)[] };
  });
  return { t, lines };
}

function points({ t, min, max }: Curve): { t: number[]; values: (number | null)[] } {
  const start = t[0] ?? 0;
  const half = ((t.at(-1) ?? start) - start) / Math.max(t.length - 1, 1) / 2;
  const times: number[] = [];
  const values: (number | null)[] = [];
  t.forEach((time, k) => {
    const [low, high] = [min[k] ?? null, max[k] ?? null];
    times.push(time - start);
    values.push(low);
    if (high !== low) {
      times.push(time - start + half);
      values.push(high);
    }
  });
  return { t: times, values };
}
