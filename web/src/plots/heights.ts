/** How high a plot reaches: over its lines, and over the shades behind them as far as the lines stay readable.

Where a joint rests, friction leaves an interval many times as wide as what is asked for.
*/

type Values = ArrayLike<number | null | undefined>;

const MARGIN = 0.08; // of the height of the lines
const MOST_SHADE = 0.5; // of the same, above and below

export function room(lines: readonly Values[], shades: readonly Values[]): [number, number] {
  const [low, high] = ends(lines);
  if (!(high >= low)) return [-1, 1];
  const height = high - low || Math.abs(high) || 1;
  const [bottom, top] = ends(shades);
  const least = Math.max(Math.min(low, bottom), low - MOST_SHADE * height);
  const most = Math.min(Math.max(high, top), high + MOST_SHADE * height);
  return [least - MARGIN * height, most + MARGIN * height];
}

function ends(all: readonly Values[]): [number, number] {
  let [low, high] = [Infinity, -Infinity];
  for (const values of all)
    for (let k = 0; k < values.length; k += 1) {
      const value = values[k];
      if (value === null || value === undefined) continue;
      if (value < low) low = value;
      if (value > high) high = value;
    }
  return [low, high];
}
