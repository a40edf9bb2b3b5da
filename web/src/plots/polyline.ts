/** Tiles as lines that can be drawn: up and down once per stretch, a plain line where every sample is there. */

import { needed, type Line } from "./channels";
import type { Tiles } from "./series";

/** Two standard deviations: where about 95 of 100 true values lie. */
export const DOUBT = 2;

type Values = (number | null)[];
export type Drawable = { t: number[]; lines: Values[]; bands: ({ low: Values; high: Values } | null)[] };

/** A line is left out until the tiles hold its channels. scale: of the file's values to those that are drawn. */
export function drawable(inFile: Tiles | undefined, lines: readonly Line[], doubts: boolean, scale: number): Drawable {
  const tiles = inFile && scale !== 1 ? scaled(inFile, scale) : inFile;
  if (!tiles) return { t: [], lines: lines.map(() => []), bands: lines.map(() => null) };
  const t = wholeSamples(tiles) ? tiles.t : tiles.t.flatMap((each) => [each, each]);
  return {
    t,
    lines: lines.map(({ channel }) => zigzag(tiles, channel)),
    bands: lines.map((line) => (doubts ? band(tiles, line) : null)),
  };
}

function scaled(tiles: Tiles, scale: number): Tiles {
  const times = (values: Values) => values.map((value) => (value === null ? null : scale * value));
  const channels = Object.entries(tiles.channels).map(([name, { min, max }]) => [name, { min: times(min), max: times(max) }]);
  return { ...tiles, channels: Object.fromEntries(channels) as Tiles["channels"] };
}

/** Whether each tile is one sample. */
export function wholeSamples(tiles: Tiles): boolean {
  return tiles.samples === tiles.t.length;
}

function zigzag(tiles: Tiles, channel: string): Values {
  const found = tiles.channels[channel];
  if (!found) return tiles.t.flatMap(() => (wholeSamples(tiles) ? [null] : [null, null]));
  if (wholeSamples(tiles)) return found.min;
  return found.min.flatMap((low, k) => (k % 2 ? [found.max[k] ?? null, low] : [low, found.max[k] ?? null]));
}

/** Value ± two standard deviations; where friction leaves an interval only, that. */
function band(tiles: Tiles, line: Line): { low: Values; high: Values } | null {
  if (!line.std || needed([line]).some((each) => !tiles.channels[each])) return null;
  const value = tiles.channels[line.channel];
  const std = tiles.channels[line.std];
  const lowest = line.low ? tiles.channels[line.low] : undefined;
  const highest = line.high ? tiles.channels[line.high] : undefined;
  const repeat = wholeSamples(tiles) ? 1 : 2;
  const low: Values = [];
  const high: Values = [];
  tiles.t.forEach((_, k) => {
    const doubt = DOUBT * (std?.max[k] ?? Number.NaN);
    const bottom = smaller(lowest?.min[k], minus(value?.min[k], doubt));
    const top = larger(highest?.max[k], plus(value?.max[k], doubt));
    for (let n = 0; n < repeat; n += 1) {
      low.push(bottom);
      high.push(top);
    }
  });
  return { low, high };
}

function plus(value: number | null | undefined, more: number): number | null {
  return value === null || value === undefined || Number.isNaN(more) ? null : value + more;
}

function minus(value: number | null | undefined, less: number): number | null {
  return plus(value, -less);
}

function smaller(one: number | null | undefined, two: number | null): number | null {
  return one === null || one === undefined ? two : two === null ? one : Math.min(one, two);
}

function larger(one: number | null | undefined, two: number | null): number | null {
  return one === null || one === undefined ? two : two === null ? one : Math.max(one, two);
}
