import { MultiSelect, Stack, Switch, Text } from "@mantine/core";
import { useEffect, useMemo, useRef, type KeyboardEvent } from "react";

import { GROUPS, panelsOf } from "./channels";
import { useRestingTime, type Cursor } from "./cursor";
import { ExportMenu } from "./ExportMenu";
import { Feet, STANDS } from "./Feet";
import type { Window } from "./Plot";
import { PlotPanel } from "./PlotPanel";
import styles from "./PlotStack.module.css";
import { PlotTools } from "./PlotTools";
import type { SeriesFacts, Source } from "./series";
import { isWhole, panned, stepped, within, zoomed } from "./steps";
import type { View } from "./view";

const MOST_PLOTS = 10;
const FAR = 10; // samples per step with Shift
const REST_MS = 400;

type Props = {
  source: Source;
  series: SeriesFacts;
  view: View;
  first: string[];
  cursor: Cursor;
  motion?: boolean;
  onView: (change: Partial<View>) => void;
};

/** Plots of one series below each other, over the same time and with one cursor. first: plots shown by default. motion:
of a person or a plan, see `panelsOf`. */
export function PlotStack({ source, series, view, first, cursor, motion = false, onView }: Props) {
  const panels = useMemo(() => panelsOf(series, motion), [series, motion]);
  const feet = useMemo(() => series.channels.filter(({ name, kind }) => kind === "truth" && name.startsWith(STANDS)), [series]);
  const keys = (view.show ?? first).filter((key) => panels.some((panel) => panel.key === key));
  const shown = keys.map((key) => panels.find((panel) => panel.key === key)!);
  const doubtful = panels.some(({ lines }) => lines.some(({ std }) => std));
  const whole = { from: series.start, to: series.end };
  const [from, to] = [view.from ?? whole.from, view.to ?? whole.to];
  const window = to > from ? within({ from, to }, whole) : whole;
  useCursorInView(cursor, view.at, (at) => onView({ at }));

  const show = (wanted: Window) => {
    const all = isWhole(wanted, whole);
    onView({ from: all ? null : within(wanted, whole).from, to: all ? null : within(wanted, whole).to });
  };
  const onKey = (event: KeyboardEvent, times: number[]) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const step = event.shiftKey ? FAR : 1;
    const deeds: Record<string, () => void> = {
      ArrowLeft: () => cursor.move(stepped(times, window, cursor.time, -step)),
      ArrowRight: () => cursor.move(stepped(times, window, cursor.time, step)),
      Home: () => cursor.move(window.from),
      End: () => cursor.move(window.to),
      PageUp: () => show(panned(window, whole, -0.5)),
      PageDown: () => show(panned(window, whole, 0.5)),
      "+": () => show(zoomed(window, whole, 0.5, cursor.time)),
      "=": () => show(zoomed(window, whole, 0.5, cursor.time)),
      "-": () => show(zoomed(window, whole, 2, cursor.time)),
      "0": () => show(whole),
    };
    const deed = deeds[event.key];
    if (!deed) return;
    event.preventDefault();
    deed();
  };
  const toggle = (channel: string) =>
    onView({ hide: view.hide.includes(channel) ? view.hide.filter((each) => each !== channel) : [...view.hide, channel] });

  return (
    <Stack gap="sm">
      <MultiSelect
        label="Plots"
        description={`Up to ${MOST_PLOTS} below each other; type a joint’s name to find it.`}
        data={GROUPS.map((group) => ({ group, items: optionsOf(panels, group) })).filter(({ items }) => items.length)}
        value={keys}
        onChange={(wanted) => onView({ show: wanted })}
        maxValues={MOST_PLOTS}
        searchable
        hidePickedOptions
        maxDropdownHeight={320}
        nothingFoundMessage="This log has no such channel"
      />
      <PlotTools window={window} whole={whole} cursor={cursor} onWindow={show}>
        {doubtful && (
          <Switch
            size="sm"
            label="Uncertainty (± 2 std)"
            checked={view.doubts}
            onChange={(event) => onView({ doubts: event.currentTarget.checked })}
          />
        )}
        <ExportMenu source={source} log={series.name} panels={shown} hidden={view.hide} doubts={view.doubts} window={window} />
      </PlotTools>
      <Text size="xs" c="dimmed">
        Drag across a plot to zoom, double-click for all of it. In a plot: ← → move the cursor (Shift: ten times as
        far), + − zoom, 0 shows the whole, Page ↑ ↓ move the window.
        {doubtful && " A wide shade: the joint rests, and friction leaves an interval only."}
      </Text>
      <div className={styles.stack}>
        {feet.length > 0 && (
          <Feet source={source} log={series.name} feet={feet.map(({ name }) => name)} window={window} cursor={cursor} />
        )}
        {shown.map((panel, k) => (
          <PlotPanel
            key={panel.key}
            source={source}
            log={series.name}
            panel={panel}
            hidden={view.hide}
            doubts={view.doubts}
            last={k === shown.length - 1}
            window={window}
            cursor={cursor}
            onZoom={show}
            onWhole={() => show(whole)}
            onKey={onKey}
            onToggle={toggle}
          />
        ))}
        {shown.length === 0 && <Text c="dimmed">No plot is chosen. Choose one above.</Text>}
      </div>
    </Stack>
  );
}

function optionsOf(panels: ReturnType<typeof panelsOf>, group: string) {
  return panels.filter((panel) => panel.group === group).map((panel) => ({ value: panel.key, label: panel.title }));
}

/** The address follows the cursor once it rests; the cursor follows the address where somebody else changed that. */
function useCursorInView(cursor: Cursor, at: number | null, keep: (at: number | null) => void): void {
  const kept = useRef(at);
  const rested = useRestingTime(cursor, REST_MS);
  useEffect(() => {
    if (at === kept.current) return;
    kept.current = at;
    if (at !== null) cursor.move(at);
  }, [at, cursor]);
  useEffect(() => {
    const rounded = rested === null ? null : Number(rested.toFixed(4));
    if (rounded === null || rounded === kept.current) return;
    kept.current = rounded;
    keep(rounded);
  }, [rested]);
}
