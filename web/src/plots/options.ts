/** How a plot is set up: axes in the page's colours, numbers with true signs, drag to zoom along time. */

import uPlot from "uplot";

import type { Line } from "./channels";
import { room } from "./heights";
import { ground, pen, shade, type Scheme } from "./looks";
import { tickWords } from "./ticks";

type Setup = {
  unit: string;
  lines: Line[];
  banded: boolean[];
  width: number;
  height: number;
  timed: boolean;
  scheme: () => Scheme;
  window: () => { from: number; to: number };
  onZoom: (window: { from: number; to: number }) => void;
};

const SMALLEST_DRAG = 6; // pixels
const FONT = "12px system-ui, sans-serif";

export function optionsOf({ unit, lines, banded, width, height, timed, scheme, window, onZoom }: Setup): uPlot.Options {
  const withBand = lines.filter((_, k) => banded[k]);
  const edge: uPlot.Series = { stroke: "transparent", width: 0, points: { show: false } };
  return {
    width,
    height,
    padding: [8, 12, 0, 0],
    legend: { show: false },
    focus: { alpha: 1 },
    cursor: {
      x: false,
      y: false,
      points: { show: false },
      drag: { x: true, y: false, setScale: false, dist: SMALLEST_DRAG },
      bind: { dblclick: () => null },
    },
    scales: { x: { time: false, range: () => [window().from, window().to] }, y: { range: (plot) => heights(plot, 2 * withBand.length) } },
    series: [{}, ...withBand.flatMap(() => [edge, edge]), ...lines.map((line) => seriesOf(line, scheme))],
    bands: withBand.map((line, k) => ({
      series: [2 * k + 2, 2 * k + 1],
      fill: () => shade(line.look, scheme()),
    })),
    axes: [axisOf(timed ? "time [s]" : "", scheme, { space: 70, size: timed ? 28 : 26 }), axisOf(unit && `[${unit}]`, scheme, { space: 32, size: 52 })],
    hooks: {
      setSelect: [
        (plot) => {
          const { left, width: wide } = plot.select;
          if (wide < SMALLEST_DRAG) return;
          plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
          onZoom({ from: plot.posToVal(left, "x"), to: plot.posToVal(left + wide, "x") });
        },
      ],
    },
  };
}

/** From the lines alone and the shades as far as they leave the lines readable. */
function heights(plot: uPlot, shades: number): [number, number] {
  return room(plot.data.slice(1 + shades), plot.data.slice(1, 1 + shades));
}

function seriesOf(line: Line, scheme: () => Scheme): uPlot.Series {
  const { width, dash } = pen(line.look, scheme());
  return {
    label: line.words,
    stroke: () => pen(line.look, scheme()).colour,
    width,
    ...(dash && { dash }),
    points: { show: false },
    spanGaps: false,
  };
}

function axisOf(label: string, scheme: () => Scheme, { space, size }: { space: number; size: number }): uPlot.Axis {
  return {
    ...(label && { label, labelFont: FONT, labelSize: 18, labelGap: 0 }),
    font: FONT,
    size,
    space,
    stroke: () => ground(scheme()).quiet,
    grid: { stroke: () => ground(scheme()).grid, width: 1 },
    ticks: { stroke: () => ground(scheme()).grid, width: 1, size: 5 },
    values: (_, found) => tickWords(found),
  };
}
