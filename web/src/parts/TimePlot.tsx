import "uplot/dist/uPlot.min.css";

import { useComputedColorScheme } from "@mantine/core";
import { useElementSize } from "@mantine/hooks";
import { useLayoutEffect, useRef } from "react";
import type uPlot from "uplot";

import { madePlot } from "../plots/made";
import { tickWords } from "../plots/ticks";
import styles from "./TimePlot.module.css";

/** look: which pen, from 0; old: how it was before, dashed. values: one for each time. */
export type TimeLine = { name: string; values: (number | null)[]; look: number; old?: boolean };

/** Where something was found, at a time or between two. */
export type TimeMark = { from: number; to: number };

type Props = {
  /** What is drawn, for those who do not see it. */
  label: string;
  unit: string;
  t: number[];
  lines: TimeLine[];
  marks?: TimeMark[];
  height?: number;
  xLabel?: string;
};

const PENS = [
  { light: "#0b5a6f", dark: "#79cfe6" },
  { light: "#a8195f", dark: "#ff9cc9" },
  { light: "#2b7a3d", dark: "#86d99a" },
  { light: "#a85400", dark: "#ffb36b" },
  { light: "#6a3fb5", dark: "#c5a8ff" },
  { light: "#1d5fc4", dark: "#8db9ff" },
  { light: "#4d5a61", dark: "#b8c4ca" },
] as const;
const INK = { light: "#4f5b61", dark: "#b3bdc2" };
const GRID = { light: "#e3e8ea", dark: "#3a4247" };
const MARK = { light: "#b0202040", dark: "#ffa8a050" };
const OLD = [6, 4];
const FONT = "12px system-ui, sans-serif";

/** A few curves over time, small and without controls; the figures stand in a table beside it. */
export function TimePlot({ label, unit, t, lines, marks = [], height = 240, xLabel = "time [s]" }: Props) {
  const scheme = useComputedColorScheme("light");
  const { ref, width } = useElementSize();
  const room = useRef<HTMLDivElement>(null);
  const plot = useRef<uPlot | null>(null);
  const looks = JSON.stringify([unit, xLabel, lines.map((line) => [line.name, line.look, line.old])]);
  const marked = useRef(marks);
  marked.current = marks;

  useLayoutEffect(() => {
    if (!room.current || width === 0) return;
    const made = madePlot(
      options(unit, xLabel, lines, scheme, width, height, () => marked.current),
      [t, ...lines.map((line) => line.values)] as uPlot.AlignedData,
      room.current,
    );
    plot.current = made;
    return () => {
      made.destroy();
      plot.current = null;
    };
    // New values alone are handed over below.
  }, [looks, scheme, width === 0]);

  useLayoutEffect(() => plot.current?.setData([t, ...lines.map((line) => line.values)] as uPlot.AlignedData), [t, lines]);
  useLayoutEffect(() => plot.current?.redraw(false), [marks]);
  useLayoutEffect(() => void (width > 0 && plot.current?.setSize({ width, height })), [width, height]);

  return (
    <div>
      <ul className={styles.legend}>
        {lines.map((line) => (
          <li key={line.name + String(line.old)}>
            <svg width={26} height={8} aria-hidden>
              <line x1={0} x2={26} y1={4} y2={4} stroke={penOf(line.look)[scheme]} strokeWidth={3} strokeDasharray={line.old ? OLD.join(" ") : undefined} />
            </svg>
            {line.name}
          </li>
        ))}
      </ul>
      <div ref={ref} className={styles.plot} style={{ height }}>
        <div ref={room} role="img" aria-label={label} />
      </div>
    </div>
  );
}

export function penOf(look: number): { light: string; dark: string } {
  return PENS[look % PENS.length] ?? PENS[0];
}

function options(
  unit: string,
  xLabel: string,
  lines: TimeLine[],
  scheme: "light" | "dark",
  width: number,
  height: number,
  marks: () => TimeMark[],
): uPlot.Options {
  const axis = (label: string, size: number): uPlot.Axis => ({
    label,
    labelFont: FONT,
    labelSize: 18,
    font: FONT,
    size,
    stroke: INK[scheme],
    grid: { stroke: GRID[scheme], width: 1 },
    ticks: { stroke: GRID[scheme], width: 1 },
    values: (_, found) => tickWords(found),
  });
  return {
    width,
    height,
    legend: { show: false },
    cursor: { show: false },
    scales: { x: { time: false } },
    series: [
      {},
      ...lines.map((line) => ({
        label: line.name,
        stroke: penOf(line.look)[scheme],
        width: line.old ? 1.5 : 2,
        ...(line.old && { dash: OLD }),
        points: { show: false },
      })),
    ],
    axes: [axis(xLabel, 44), axis(unit && `[${unit}]`, 62)],
    hooks: { drawAxes: [(made) => drawMarks(made, marks(), MARK[scheme])] },
  };
}

/** A stripe where something was found, at least two pixels wide. */
function drawMarks(made: uPlot, marks: TimeMark[], colour: string): void {
  const { ctx, bbox } = made;
  ctx.save();
  ctx.fillStyle = colour;
  for (const { from, to } of marks) {
    const left = made.valToPos(from, "x", true);
    const right = made.valToPos(to, "x", true);
    const wide = Math.max(right - left, 2 * devicePixelRatio);
    const start = Math.min(Math.max(left - (wide - (right - left)) / 2, bbox.left), bbox.left + bbox.width);
    ctx.fillRect(start, bbox.top, Math.min(wide, bbox.left + bbox.width - start), bbox.height);
  }
  ctx.restore();
}
