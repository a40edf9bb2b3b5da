import { Title, useComputedColorScheme } from "@mantine/core";
import { useElementSize } from "@mantine/hooks";

import { figure } from "../parts/digits";
import { useTime, type Cursor } from "./cursor";
import styles from "./Feet.module.css";
import { ground } from "./looks";
import type { Window } from "./Plot";
import { useTiles, type Source, type Tiles } from "./series";

export const STANDS = "stands."; // and a foot: channels that are 1 while it stands
const STEP = 200; // a page that grows a little need not ask again

type Props = { source: Source; log: string; feet: string[]; window: Window; cursor: Cursor };

/** When each foot stands, over the time of the plots below. */
export function Feet({ source, log, feet, window, cursor }: Props) {
  const { ref, width } = useElementSize<HTMLDivElement>();
  const pixels = STEP * Math.ceil((width * globalThis.devicePixelRatio) / STEP);
  const tiles = useTiles({ source, name: log, channels: feet, start: window.from, end: window.to, width: pixels });
  const at = useTime(cursor);
  const long = window.to - window.from;
  const colour = ground(useComputedColorScheme("light")).cursor;
  return (
    <section className={styles.feet} aria-label="Feet that stand" style={{ "--cursor-colour": colour } as React.CSSProperties}>
      <Title order={3} size="h5">
        Feet that stand
      </Title>
      {feet.map((channel, k) => {
        const name = channel.slice(STANDS.length);
        const spans = tiles.data ? stretches(tiles.data, channel, window.to) : [];
        const words = spans.length ? spans.map(({ from, to }) => `${figure(from)} to ${figure(to)} s`).join(", ") : "never";
        return (
          <div key={channel} className={styles.row}>
            <div ref={k === 0 ? ref : undefined} className={styles.room}>
              <svg viewBox={`0 0 ${long} 1`} preserveAspectRatio="none" role="img" aria-label={`${name} stands ${words}`} aria-busy={tiles.isFetching}>
                {spans.map(({ from, to }) => (
                  <rect key={from} x={from - window.from} y={0} width={to - from} height={1} />
                ))}
              </svg>
              {at !== null && at >= window.from && at <= window.to && (
                <span className={styles.cursor} style={{ left: `${(100 * (at - window.from)) / long}%` }} />
              )}
            </div>
            <span className={styles.name}>{name}</span>
          </div>
        );
      })}
    </section>
  );
}

/** Where a foot stands throughout a tile, joined; each lasts until the next tile begins. */
export function stretches({ t, channels }: Tiles, channel: string, end: number): Window[] {
  const found: Window[] = [];
  t.forEach((from, k) => {
    if (channels[channel]?.min[k] !== 1) return;
    const [last, to] = [found.at(-1), t[k + 1] ?? end];
    if (last && last.to === from) last.to = to;
    else found.push({ from, to });
  });
  return found;
}
