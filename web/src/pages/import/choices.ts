/** What is said of each column, made of a mapping and made into one. */

import type { Column, Preview } from "../../api/imports";
import { QUANTITIES, WRENCH, XYZ, type Quantity } from "./quantities";

/** means: "" is not said yet. of: joint or sensor; axis: x …, fx …; order: of a dataset with all six components. */
export type Choice = {
  means: Quantity | "ignore" | "";
  of: string;
  axis: string;
  unit: string;
  moment_unit: string;
  sign: 1 | -1;
  side: "joint" | "motor";
  scale: number;
  offset: number | string;
  order: "force_first" | "couple_first";
};
export type Choices = Record<string, Choice>;

/** What a mapping says beside its columns; frames: sensor -> the log's axes in the order of the robot's x y z. */
export type Whole = {
  columns: Choices;
  frames: Record<string, string>;
  rateHz: number | null;
  delay: number;
  rest: Record<string, unknown>;
  layout: Record<string, unknown> | null;
};

export const NOTHING: Choice = {
  means: "",
  of: "",
  axis: "",
  unit: "",
  moment_unit: "Nm",
  sign: 1,
  side: "joint",
  scale: 1,
  offset: 0,
  order: "force_first",
};
export const AS_IS = "x y z";

type Entry = Record<string, unknown> & { channel: string; unit: string };
type Part = { columns?: string[]; dataset?: string; sign?: 1 | -1; rotation?: unknown; scale?: number };
type FileEntry = {
  file: string;
  time?: { column: string; unit: string; delay_s?: number };
  rate_hz?: number;
  layout?: Record<string, unknown>;
  columns?: Record<string, Entry>;
  arrays?: (Entry & { dataset: string; channels: string[] })[];
  vectors?: (Part & { channel: "acc" | "gyro"; unit: string })[];
  wrenches?: (Part & { sensor: string; order: Choice["order"]; force_unit: string; moment_unit: string })[];
  ignore?: "rest" | string[];
};
export type Mapping = Record<string, unknown> & { files: FileEntry[] };

/** Null where the mapping says more than the table can show: several files, or rotations as matrices. */
export function choicesOf(mapping: Mapping, preview: Preview): Whole | null {
  const { files, version: _, ...rest } = mapping;
  const [file] = files;
  if (!file || files.length !== 1) return null;
  const columns: Choices = Object.fromEntries(preview.columns.map(({ name }) => [name, NOTHING]));
  const frames: Record<string, string> = {};
  const say = (name: string, choice: Partial<Choice>) => {
    if (name in columns) columns[name] = { ...NOTHING, ...choice };
  };
  if (file.time) say(file.time.column, { means: "t", unit: file.time.unit });
  for (const [name, entry] of Object.entries(file.columns ?? {})) say(name, { ...channelOf(entry.channel), ...kept(entry) });
  for (const entry of file.arrays ?? []) say(entry.dataset, { ...channelOf(entry.channels[0] ?? ""), of: "", ...kept(entry) });
  for (const { channel, columns: names, dataset, unit, sign = 1, rotation, scale = 1 } of file.vectors ?? []) {
    if (rotation !== undefined && typeof rotation !== "string") return null;
    if (rotation) frames[channel] = rotation;
    if (dataset) say(dataset, { means: channel, unit, sign, scale });
    names?.forEach((name, k) => say(name, { means: channel, axis: XYZ[k] ?? "", unit, sign, scale }));
  }
  for (const { sensor, columns: names, dataset, order, force_unit, moment_unit, sign = 1, rotation } of file.wrenches ?? []) {
    if (rotation !== undefined && typeof rotation !== "string") return null;
    if (rotation) frames[`ft.${sensor}`] = rotation;
    const axes = order === "force_first" ? WRENCH : [...WRENCH.slice(3), ...WRENCH.slice(0, 3)];
    if (dataset) say(dataset, { means: "ft", of: sensor, unit: force_unit, moment_unit, sign, order });
    names?.forEach((name, k) => {
      const axis = axes[k] ?? "";
      say(name, { means: "ft", of: sensor, axis, unit: axis.startsWith("f") ? force_unit : moment_unit, sign });
    });
  }
  for (const { name } of preview.columns) {
    const left = file.ignore === "rest" ? columns[name]?.means === "" : file.ignore?.includes(name);
    if (left) columns[name] = { ...NOTHING, means: "ignore" };
  }
  return { columns, frames, rateHz: file.rate_hz ?? null, delay: file.time?.delay_s ?? 0, rest, layout: file.layout ?? null };
}

/** A mapping as it may be handed in; what is not said yet is left out, and refused by name. */
export function mappingOf(whole: Whole, preview: Preview, joints: string[]): Mapping {
  const { columns, frames, rateHz, delay, rest, layout } = whole;
  const entry: FileEntry = { file: preview.file };
  if (layout ?? !preview.header) entry.layout = layout ?? { header: false };
  const said = preview.columns.flatMap((column) => {
    const choice = columns[column.name];
    return choice && choice.means !== "" ? [{ column, choice }] : [];
  });
  const time = said.find(({ choice }) => choice.means === "t");
  if (time) entry.time = { column: time.column.name, unit: time.choice.unit, ...(delay !== 0 && { delay_s: delay }) };
  else if (rateHz) entry.rate_hz = rateHz;
  const plain = said.filter(({ column, choice }) => column.dtype !== "array" && choice.means !== "t" && choice.means !== "ignore");
  const turned = new Set<string>();
  entry.vectors = [];
  entry.wrenches = [];
  for (const sensor of Object.keys(sensorsOf(said))) {
    const members = plain.filter(({ choice }) => sensorOf(choice) === sensor);
    const rotation = frames[sensor];
    if (!rotation || rotation.trim() === AS_IS || members.length === 0) continue;
    members.forEach(({ column }) => turned.add(column.name));
    const axes = sensor.startsWith("ft.") ? WRENCH : XYZ;
    const names = axes.map((axis) => members.find(({ choice }) => choice.axis === axis)?.column.name ?? "");
    const first = (axis: string) => members.find(({ choice }) => choice.axis === axis)?.choice;
    const sign = members[0]?.choice.sign ?? 1;
    if (sensor === "acc" || sensor === "gyro") {
      entry.vectors.push({ channel: sensor, columns: names, unit: first("x")?.unit ?? "", sign, rotation });
    } else {
      const units = { force_unit: first("fx")?.unit ?? "", moment_unit: first("mx")?.unit ?? "" };
      entry.wrenches.push({ sensor: sensor.slice(3), columns: names, order: "force_first", ...units, sign, rotation });
    }
  }
  entry.columns = Object.fromEntries(
    plain.filter(({ column }) => !turned.has(column.name)).map(({ column, choice }) => [column.name, plainEntry(choice)]),
  );
  entry.arrays = [];
  for (const { column, choice } of said) if (column.dtype === "array") array(entry, column, choice, frames, joints);
  entry.ignore = said.filter(({ choice }) => choice.means === "ignore").map(({ column }) => column.name);
  for (const key of ["columns", "arrays", "vectors", "wrenches", "ignore"] as const) {
    if (Object.keys(entry[key] ?? {}).length === 0) delete entry[key];
  }
  return { version: 1, ...rest, files: [entry] };
}

/** Sensors whose axes can be turned: with all of their components. */
export function sensorsOf(said: { column: Column; choice: Choice }[]): Record<string, number> {
  const found: Record<string, number> = {};
  for (const { column, choice } of said) {
    const sensor = sensorOf(choice);
    if (sensor) found[sensor] = (found[sensor] ?? 0) + (column.dtype === "array" ? 6 : 1);
  }
  return Object.fromEntries(Object.entries(found).filter(([name, count]) => count >= (name.startsWith("ft.") ? 6 : 3)));
}

function sensorOf({ means, of }: Choice): string | null {
  if (means === "acc" || means === "gyro") return means;
  return means === "ft" && of ? `ft.${of}` : null;
}

export function channelName({ means, of, axis }: Choice): string {
  const said = means === "" || means === "ignore" ? null : QUANTITIES[means];
  if (!said) return "";
  if (said.of === "joint") return `${means}.${of}`;
  if (said.of === "wrench") return `ft.${of}.${axis}`;
  return said.of === null ? "t" : `${means}.${axis}`;
}

export function channelOf(name: string): Partial<Choice> {
  const [kind = "", ...rest] = name.split(".");
  if (!(kind in QUANTITIES)) return {};
  const means = kind as Quantity;
  if (means === "t") return { means };
  if (means === "ft") return { means, of: rest.slice(0, -1).join("."), axis: rest.at(-1) ?? "" };
  return QUANTITIES[means].of === "joint" ? { means, of: rest.join(".") } : { means, axis: rest.join(".") };
}

function kept(entry: Record<string, unknown>): Partial<Choice> {
  const { unit, sign = 1, side = "joint", scale = 1, offset = 0 } = entry as Partial<Choice>;
  return { unit, sign, side, scale, offset };
}

function plainEntry(choice: Choice): Entry {
  const { unit, sign, side, scale, offset } = choice;
  return {
    channel: channelName(choice),
    unit,
    ...(sign !== 1 && { sign }),
    ...(side !== "joint" && { side }),
    ...(scale !== 1 && { scale }),
    ...(offset !== 0 && { offset }),
  };
}

/** A dataset of several dimensions: an IMU, a wrench, or one row for each joint. */
function array(entry: FileEntry, { name }: Column, choice: Choice, frames: Record<string, string>, joints: string[]): void {
  const { means, unit, moment_unit, sign, order, of } = choice;
  const frame = frames[sensorOf(choice) ?? ""];
  const rotation = frame && frame.trim() !== AS_IS ? { rotation: frame } : {};
  if (means === "acc" || means === "gyro") entry.vectors?.push({ channel: means, dataset: name, unit, sign, ...rotation });
  else if (means === "ft") {
    entry.wrenches?.push({ sensor: of, dataset: name, order, force_unit: unit, moment_unit, sign, ...rotation });
  } else if (means !== "ignore" && means !== "" && means !== "t") {
    const { channel: _, ...rest } = plainEntry(choice);
    entry.arrays?.push({ dataset: name, channels: joints.map((joint) => `${means}.${joint}`), ...rest } as never);
  }
}
