/** What a channel of a series shows, from its name: which plot it belongs to, what it is called, how it looks.

Names are those of `docs/study.md`: `measured.tau.torso_pitch`, `support_a.torso_pitch`, `band.A_left.tension`; of a log
as it was read those of its channels.
*/

import { motionLine, shownUnit } from "./motion";
import { ofJoint, rawLine } from "./raw";
import type { SeriesFacts } from "./series";

type Channel = SeriesFacts["channels"][number];
export type Look =
  | "measured"
  | "predicted"
  | "prior"
  | "support_a"
  | "support_b"
  | "support_paired"
  | "band_model"
  | `other${0 | 1 | 2 | 3 | 4 | 5}`;

/** std: channel of its standard deviation; low, high: of the ends of an interval, where there is only one. */
export type Line = { channel: string; words: string; look: Look; std?: string; low?: string; high?: string };

/** key: names it in an address. group: heading of the picker. scale: of the file's values to those in `unit`. */
export type Panel = { key: string; title: string; group: string; unit: string; scale: number; lines: Line[] };
type Named = Omit<Panel, "unit" | "scale" | "lines">;

const MODELS: [string, string, Look][] = [
  ["measured", "Measured", "measured"],
  ["filtered", "Low-passed, as the fit takes it", "other0"],
  ["predicted", "Identified model", "predicted"],
  ["predicted_prior", "Maker’s values", "prior"],
];
const APPROACHES: [string, string, Look][] = [
  ["support_a", "A: without − with", "support_a"],
  ["support_b", "B: model − measured", "support_b"],
  ["support_paired", "Paired: B with − B without", "support_paired"],
  ["support_prior", "B, maker’s values", "prior"],
  ["support_band_model", "Band model", "band_model"],
];
const BAND = /^band\.(.+)\.(tension|length)$/;
const SENSOR = /^(.+)\.([fm])([xyz])$/;
export const GROUPS = [
  "Supporting torque",
  "Joint torque",
  "Motor current",
  "Joint position",
  "Joint velocity",
  "Joint acceleration",
  "Temperature",
  "Base",
  "IMU",
  "Sensors",
  "Bands",
  "Trunk",
  "Margins",
  "Shares of bounds",
  "Person",
  "Other",
] as const;

/** Every plot that a series has channels for. motion: in the units of a motion's tables; joints as planned. */
export function panelsOf(series: SeriesFacts, motion = false): Panel[] {
  const channels = new Map(series.channels.map((each) => [each.name, each]));
  const panels = new Map<string, Panel>();
  const add = (channel: Channel, panel: Named, line: Omit<Line, "channel">) => {
    const [unit, scale] = motion ? shownUnit(channel.name, channel.unit) : [channel.unit, 1];
    const found = panels.get(panel.key) ?? { ...panel, unit, scale, lines: [] };
    panels.set(panel.key, { ...found, lines: [...found.lines, { ...line, channel: channel.name }] });
  };
  for (const channel of series.channels) {
    if (channel.kind !== "number") continue;
    const [head = "", rest = ""] = split(channel.name);
    const model = MODELS.find(([part]) => part === head);
    const approach = APPROACHES.find(([part]) => part === head);
    const band = BAND.exec(channel.name);
    const raw = motionLine(channel.name) ?? rawLine(channel.name, motion ? "planned" : undefined);
    if (model) add(channel, bodyPanel(rest), { words: model[1], look: model[2] });
    else if (approach) {
      const ends = { std: `${head}_std.${rest}`, low: `${head}_low.${rest}`, high: `${head}_high.${rest}` };
      const known = Object.fromEntries(Object.entries(ends).filter(([, name]) => channels.has(name)));
      add(channel, supportPanel(rest), { words: approach[1], look: approach[2], ...known });
    } else if (band) {
      const tension = band[2] === "tension";
      const title = tension ? "Tension of the bands" : "Length of the bands";
      const panel = { key: tension ? "tension" : "length", title, group: "Bands" };
      add(channel, panel, { words: band[1] as string, look: other(panels.get(panel.key)?.lines.length ?? 0) });
    } else if (raw) {
      const { words, ...panel } = raw;
      add(channel, panel, { words, look: other(panels.get(panel.key)?.lines.length ?? 0) });
    } else if (!/^support_\w+_(std|low|high)$/.test(head)) {
      add(channel, { key: channel.name, title: channel.name, group: "Other" }, { words: channel.name, look: other(0) });
    }
  }
  return [...panels.values()].sort((one, two) => rank(one) - rank(two));
}

function bodyPanel(name: string): Named {
  const [kind, rest] = split(name);
  const moved = kind === "tau" ? null : ofJoint(name);
  if (moved) return moved;
  if (kind === "tau") return { key: name, title: `Torque of ${rest}`, group: "Joint torque" };
  if (kind === "base") {
    const what = rest.startsWith("f") ? "force" : "moment";
    return { key: name, title: `Base ${what} ${rest.slice(1)}`, group: "Base" };
  }
  const sensor = kind === "ft" ? SENSOR.exec(rest) : null;
  if (sensor) return { key: name, title: `${sensor[2] === "f" ? "Force" : "Moment"} ${sensor[3]} of ${sensor[1]}`, group: "Sensors" };
  return { key: name, title: name, group: "Other" };
}

function supportPanel(joint: string): Named {
  return { key: `support.${joint}`, title: `Supporting torque at ${joint}`, group: "Supporting torque" };
}

function split(name: string): [string, string] {
  const dot = name.indexOf(".");
  return dot < 0 ? [name, ""] : [name.slice(0, dot), name.slice(dot + 1)];
}

function other(k: number): Look {
  return `other${(k % 6) as 0 | 1 | 2 | 3 | 4 | 5}`;
}

function rank(panel: Panel): number {
  const place = (GROUPS as readonly string[]).indexOf(panel.group);
  return place < 0 ? GROUPS.length : place;
}

/** Every channel that drawing some lines takes. */
export function needed(lines: readonly Line[]): string[] {
  return lines.flatMap(({ channel, std, low, high }) => [channel, ...[std, low, high].filter((each) => each !== undefined)]);
}
