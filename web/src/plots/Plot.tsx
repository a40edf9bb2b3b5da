import "uplot/dist/uPlot.min.css";

import { useComputedColorScheme } from "@mantine/core";
import { useLayoutEffect, useMemo, useRef, type KeyboardEvent } from "react";
import type uPlot from "uplot";

import type { Line } from "./channels";
import type { Cursor } from "./cursor";
import { ground, type Scheme } from "./looks";
import { madePlot } from "./made";
import { optionsOf } from "./options";
import styles from "./Plot.module.css";
import type { Drawable } from "./polyline";

export type Window = { from: number; to: number };

type Props = {
  label: string;
  words: string;
  unit: string;
  lines: Line[];
  drawn: Drawable;
  window: Window;
  cursor: Cursor;
  width: number;
  height: number;
  timed: boolean;
  onZoom: (window: Window) => void;
  onWhole: () => void;
  onKey: (event: KeyboardEvent) => void;
};

/** One plot over time: drag zooms, hovering or touching moves the cursor, keys do both. */
export function Plot(props: Props) {
  const { label, words, unit, lines, drawn, window, cursor, width, height, timed, onZoom, onWhole, onKey } = props;
  const scheme: Scheme = useComputedColorScheme("light");
  const room = useRef<HTMLDivElement>(null);
  const plot = useRef<uPlot | null>(null);
  const now = useRef({ window, onZoom, onWhole, scheme });
  now.current = { window, onZoom, onWhole, scheme };
  const banded = drawn.bands.map((band) => band !== null);
  const shape = JSON.stringify([unit, timed, lines.map((line) => [line.channel, line.look]), banded]);

  const data = useMemo(() => aligned(drawn), [drawn]);

  useLayoutEffect(() => {
    const made = madePlot(
      optionsOf({
        unit,
        lines,
        banded,
        width,
        height,
        timed,
        scheme: () => now.current.scheme,
        window: () => now.current.window,
        onZoom: (zoomed) => now.current.onZoom(zoomed),
      }),
      data,
      room.current as HTMLDivElement,
    );
    plot.current = made;
    const stop = follow(made, cursor, () => now.current.onWhole());
    return () => {
      stop();
      made.destroy();
      plot.current = null;
    };
    // What else changes is handed over below.
  }, [shape, cursor]);

  useLayoutEffect(() => plot.current?.setData(data, false), [data]);
  useLayoutEffect(() => {
    plot.current?.setScale("x", { min: window.from, max: window.to });
  }, [window.from, window.to, data, shape]);
  useLayoutEffect(() => plot.current?.setSize({ width, height }), [width, height]);
  useLayoutEffect(() => plot.current?.redraw(false), [scheme]);

  return (
    <div
      ref={room}
      className={styles.plot}
      style={{ "--cursor-colour": ground(scheme).cursor, minHeight: height } as React.CSSProperties}
      role="slider"
      tabIndex={0}
      aria-label={label}
      aria-valuemin={window.from}
      aria-valuemax={window.to}
      aria-valuenow={cursor.time ?? window.from}
      aria-valuetext={words}
      onKeyDown={onKey}
    />
  );
}

/** Times, then low and high of each uncertainty, then the lines: uncertainties lie behind. */
function aligned(drawn: Drawable): uPlot.AlignedData {
  const bands = drawn.bands.flatMap((band) => (band ? [band.low, band.high] : []));
  return [drawn.t, ...bands, ...drawn.lines];
}

/** Pointer to cursor, and cursor to the line across the plot. Returns how to stop. */
function follow(made: uPlot, cursor: Cursor, whole: () => void): () => void {
  const line = document.createElement("div");
  line.className = styles.cursor ?? "";
  made.over.append(line);
  const draw = () => {
    const at = cursor.time;
    const left = at === null ? Number.NaN : made.valToPos(at, "x");
    const inside = left >= -0.5 && left <= made.over.clientWidth + 0.5;
    line.style.display = inside ? "block" : "none";
    if (inside) line.style.transform = `translateX(${left}px)`;
  };
  const point = (event: PointerEvent) => {
    if (event.type === "pointermove" && event.pointerType === "mouse" && event.buttons) return; // it marks a stretch
    const { left, width } = made.over.getBoundingClientRect();
    const place = Math.min(Math.max(event.clientX - left, 0), width);
    cursor.move(made.posToVal(place, "x"));
  };
  made.over.addEventListener("pointermove", point);
  made.over.addEventListener("pointerdown", point);
  made.over.addEventListener("dblclick", whole);
  made.hooks.draw = [...(made.hooks.draw ?? []), draw];
  const stop = cursor.subscribe(draw);
  draw();
  return stop;
}
