/** The window as one picture that needs nothing else: SVG with its colours, names, units and the time that it shows. */

import type { Panel, Line } from "./channels";
import { room } from "./heights";
import { ground, pen, shade, type Scheme } from "./looks";
import type { Window } from "./Plot";
import type { Drawable } from "./polyline";
import { ticks, tickWords } from "./ticks";

export type Pictured = { panel: Panel; lines: Line[]; drawn: Drawable };
type Place = { left: number; top: number; width: number; height: number };

const WIDTH = 1000;
const HEIGHT = 190;
const MARGIN = { left: 74, right: 16, title: 46, gap: 22, head: 30, foot: 26 };
const FONT = 'font-family="system-ui, sans-serif"';

/** head: what the picture is of. */
export function drawing(head: string, pictured: readonly Pictured[], window: Window, scheme: Scheme) {
  const colours = ground(scheme);
  const total = MARGIN.head + pictured.length * (MARGIN.title + HEIGHT + MARGIN.gap) + MARGIN.foot;
  const parts = [
    `<rect width="${WIDTH}" height="${total}" fill="${colours.paper}"/>`,
    words(16, 22, head, colours.quiet, 'font-size="13"'),
  ];
  pictured.forEach((each, k) => {
    const top = MARGIN.head + k * (MARGIN.title + HEIGHT + MARGIN.gap) + MARGIN.title;
    const place = { left: MARGIN.left, top, width: WIDTH - MARGIN.left - MARGIN.right, height: HEIGHT };
    parts.push(panelOf(each, place, window, scheme, k));
  });
  parts.push(words(WIDTH / 2, total - 10, "time [s]", colours.quiet, 'font-size="12" text-anchor="middle"'));
  const svg =
    `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${WIDTH} ${total}" width="${WIDTH}" height="${total}" ${FONT}>` +
    `<title>${escaped(head)}</title>${parts.join("")}</svg>`;
  return { svg, width: WIDTH, height: total };
}

function panelOf({ panel, lines, drawn }: Pictured, place: Place, window: Window, scheme: Scheme, key: number): string {
  const colours = ground(scheme);
  const { left, top, width, height } = place;
  const [low, high] = room(drawn.lines, drawn.bands.flatMap((band) => (band ? [band.low, band.high] : [])));
  const x = (t: number) => left + ((t - window.from) / (window.to - window.from)) * width;
  const y = (value: number) => top + height - ((value - low) / (high - low)) * height;
  const across = ticks(window.from, window.to, 10);
  const up = ticks(low, high, 5);
  const grid = [
    ...across.map((t) => rule(x(t), top, x(t), top + height, colours.grid)),
    ...up.map((value) => rule(left, y(value), left + width, y(value), colours.grid)),
    ...tickWords(across).map((text, k) =>
      words(x(across[k] as number), top + height + 16, text, colours.quiet, 'font-size="11" text-anchor="middle"'),
    ),
    ...tickWords(up).map((text, k) =>
      words(left - 8, y(up[k] as number) + 4, text, colours.quiet, 'font-size="11" text-anchor="end"'),
    ),
  ];
  const shades = lines.map((line, k) => area(drawn, k, x, y, shade(line.look, scheme)));
  const strokes = lines.map((line, k) => {
    const { colour, width: wide, dash } = pen(line.look, scheme);
    const look = `stroke="${colour}" stroke-width="${wide}"${dash ? ` stroke-dasharray="${dash.join(" ")}"` : ""}`;
    return `<path d="${path(drawn.t, drawn.lines[k] ?? [], x, y)}" fill="none" ${look}/>`;
  });
  return (
    words(left, top - 26, `${panel.title} [${panel.unit}]`, colours.ink, 'font-size="14" font-weight="600"') +
    legend(lines, left, top - 8, scheme) +
    grid.join("") +
    `<clipPath id="p${key}"><rect x="${left}" y="${top}" width="${width}" height="${height}"/></clipPath>` +
    `<g clip-path="url(#p${key})">${shades.join("")}${strokes.join("")}</g>`
  );
}

function legend(lines: readonly Line[], left: number, y: number, scheme: Scheme): string {
  let x = left;
  return lines
    .map((line) => {
      const { colour, width, dash } = pen(line.look, scheme);
      const dashed = dash ? ` stroke-dasharray="${dash.join(" ")}"` : "";
      const stroke = `<line x1="${x}" x2="${x + 26}" y1="${y - 4}" y2="${y - 4}" stroke="${colour}" stroke-width="${width}"${dashed}/>`;
      const text = words(x + 32, y, line.words, ground(scheme).quiet, 'font-size="12"');
      x += 32 + 7.2 * line.words.length + 18;
      return stroke + text;
    })
    .join("");
}

function path(t: readonly number[], values: readonly (number | null)[], x: Map1, y: Map1): string {
  let pen = "M";
  let text = "";
  values.forEach((value, k) => {
    if (value === null) pen = "M";
    else {
      text += `${pen}${x(t[k] as number).toFixed(1)} ${y(value).toFixed(1)}`;
      pen = "L";
    }
  });
  return text;
}

/** Between low and high, in one piece for every stretch without a gap. */
function area({ t, bands }: Drawable, k: number, x: Map1, y: Map1, fill: string): string {
  const band = bands[k];
  if (!band) return "";
  const pieces: string[] = [];
  let there: string[] = [];
  let back: string[] = [];
  const close = () => {
    if (there.length) pieces.push(`M${[...there, ...back.reverse()].join("L")}Z`);
    [there, back] = [[], []];
  };
  t.forEach((time, n) => {
    const [low, high] = [band.low[n] ?? null, band.high[n] ?? null];
    if (low === null || high === null) close();
    else {
      there.push(`${x(time).toFixed(1)} ${y(high).toFixed(1)}`);
      back.push(`${x(time).toFixed(1)} ${y(low).toFixed(1)}`);
    }
  });
  close();
  return `<path d="${pieces.join("")}" fill="${fill}"/>`;
}

type Map1 = (value: number) => number;

function rule(x1: number, y1: number, x2: number, y2: number, colour: string): string {
  return `<path d="M${x1.toFixed(1)} ${y1.toFixed(1)}L${x2.toFixed(1)} ${y2.toFixed(1)}" stroke="${colour}"/>`;
}

function words(x: number, y: number, text: string, colour: string, more = ""): string {
  return `<text x="${x.toFixed(1)}" y="${y.toFixed(1)}" fill="${colour}" ${more}>${escaped(text)}</text>`;
}

function escaped(text: string): string {
  return text.replace(/[&<>"]/g, (sign) => `&#${sign.charCodeAt(0)};`);
}
