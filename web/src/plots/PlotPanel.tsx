import { Text, Title } from "@mantine/core";
import { useElementSize } from "@mantine/hooks";
import { useMemo, type KeyboardEvent } from "react";

import { ProblemBox } from "../parts/ProblemBox";
import { needed, type Panel } from "./channels";
import { useRestingTime, type Cursor } from "./cursor";
import styles from "./PlotPanel.module.css";
import { Plot, type Window } from "./Plot";
import { drawable } from "./polyline";
import { Readings, readingWords } from "./Readings";
import { useSample, useTiles, type Source } from "./series";

const HEIGHT = 210;
const AXIS_NAME = 20; // below the last plot
const STEP = 200; // a plot that grows a little need not ask again
const REST_MS = 120;

type Props = {
  source: Source;
  log: string;
  panel: Panel;
  hidden: readonly string[];
  doubts: boolean;
  last: boolean;
  window: Window;
  cursor: Cursor;
  onZoom: (window: Window) => void;
  onWhole: () => void;
  onKey: (event: KeyboardEvent, times: number[]) => void;
  onToggle: (channel: string) => void;
};

/** A plot with its name, and beside it what its lines are at the cursor. */
export function PlotPanel(props: Props) {
  const { source, log, panel, hidden, doubts, last, window, cursor, onZoom, onWhole, onKey, onToggle } = props;
  const { ref, width } = useElementSize<HTMLDivElement>();
  const shown = useMemo(() => panel.lines.filter((line) => !hidden.includes(line.channel)), [panel, hidden]);
  const channels = useMemo(() => needed(panel.lines), [panel]);
  const pixels = Math.min(STEP * Math.ceil((width * globalThis.devicePixelRatio) / STEP), 8000);
  const tiles = useTiles({ source, name: log, channels, start: window.from, end: window.to, width: pixels });
  const drawn = useMemo(() => drawable(tiles.data, shown, doubts, panel.scale), [tiles.data, shown, doubts, panel.scale]);
  const height = HEIGHT + (last ? AXIS_NAME : 0);
  const at = useRestingTime(cursor, REST_MS);
  const sample = useSample(source, log, channels, at, panel.scale);
  return (
    <section className={styles.panel} aria-label={panel.title}>
      <Title order={3} size="h5" className={styles.title}>
        {panel.title}
      </Title>
      <div ref={ref} className={styles.room} style={{ minHeight: height }} aria-busy={tiles.isFetching}>
        {tiles.error && <ProblemBox error={tiles.error} retry={() => void tiles.refetch()} />}
        {width > 0 && tiles.data && !tiles.error && (
          <Plot
            label={`${panel.title}: time`}
            words={readingWords(shown, sample.data ?? null, panel.unit)}
            unit={panel.unit}
            lines={shown}
            drawn={drawn}
            window={window}
            cursor={cursor}
            width={width}
            height={height}
            timed={last}
            onZoom={onZoom}
            onWhole={onWhole}
            onKey={(event) => onKey(event, drawn.t)}
          />
        )}
        {tiles.isPending && (
          <Text size="sm" c="dimmed" className={styles.waiting} role="status">
            Reading …
          </Text>
        )}
      </div>
      <Readings panel={panel} hidden={hidden} sample={sample.data ?? null} cursor={cursor} onToggle={onToggle} />
    </section>
  );
}
