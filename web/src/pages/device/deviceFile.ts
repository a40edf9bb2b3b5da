/** device.yaml as it is edited: its values, and the same file with changed values, comments and all. */

import { isMap, isScalar, parseDocument, type Document } from "yaml";

import type { BandLaw } from "../../api/devices";

export type ViaPoint = { link: string; xyz: [number, number, number] };
export type Band = {
  name: string;
  group?: string;
  via_points: ViaPoint[];
  stiffness_n_per_m?: number;
  natural_length_m?: number;
  ground_truth?: boolean;
  law?: string;
  law_values?: Record<string, number>;
  bench?: { file: string; is_truth?: boolean };
};

/** Which specimen is worn, and how: `record` of device.yaml, for the configuration record of a study. */
export const RECORD = ["model", "size", "serial", "straps", "pretension", "garment"] as const;
export type Specimen = Partial<Record<(typeof RECORD)[number], string>>;
export type DeviceContent = { name: string; bands: Band[]; tied?: string[]; record: Specimen };

export function readDevice(text: string): DeviceContent {
  const page = parseDocument(text);
  const { name, bands, tied } = page.toJS() as DeviceContent;
  return { name, bands, ...(tied && { tied }), record: readRecord(page) };
}

/** The file with what differs changed in place; comments elsewhere stay. */
export function writeDevice(text: string, content: DeviceContent): string {
  const page = parseDocument(text);
  const before = page.toJS() as DeviceContent;
  if (content.name !== before.name) page.set("name", content.name);
  content.bands.forEach((band, k) => writeBand(page, k, band, before.bands[k]));
  writeRecord(page, content.record);
  return page.toString({ lineWidth: 120 });
}

function writeBand(page: Document, k: number, band: Band, before: Band | undefined): void {
  const at = ["bands", k];
  for (const key of ["stiffness_n_per_m", "natural_length_m", "ground_truth"] as const) {
    if (band[key] === before?.[key]) continue;
    if (band[key] === undefined) page.deleteIn([...at, key]);
    else page.setIn([...at, key], band[key]);
  }
  writeLaw(page, at, band, before);
  const known = before?.via_points ?? [];
  if (known.length !== band.via_points.length) {
    const points = page.createNode(band.via_points.map(({ link, xyz }) => page.createNode({ link, xyz }, { flow: true })));
    page.setIn([...at, "via_points"], points);
    return;
  }
  band.via_points.forEach(({ link, xyz }, j) => {
    const place = [...at, "via_points", j];
    if (link !== known[j]?.link) page.setIn([...place, "link"], link);
    if (xyz.some((each, axis) => each !== known[j]?.xyz[axis])) {
      page.setIn([...place, "xyz"], page.createNode(xyz, { flow: true }));
    }
  });
}

function writeLaw(page: Document, at: (string | number)[], band: Band, before: Band | undefined): void {
  if (band.law !== before?.law) {
    if (band.law === undefined) page.deleteIn([...at, "law"]);
    else page.setIn([...at, "law"], band.law);
  }
  const [values, had] = [band.law_values ?? {}, before?.law_values ?? {}];
  const names = Object.keys(values);
  if (names.length === 0) {
    if (before?.law_values) page.deleteIn([...at, "law_values"]);
  } else if (names.some((name) => !(name in had)) || Object.keys(had).some((name) => !(name in values))) {
    page.setIn([...at, "law_values"], page.createNode(values, { flow: true }));
  } else {
    names.filter((name) => values[name] !== had[name]).forEach((name) => page.setIn([...at, "law_values", name], values[name]));
  }
}

/** As it stands in the file: a serial number of 0042 is no 42. */
function readRecord(page: Document): Specimen {
  const found = RECORD.map((key) => {
    const node = page.getIn(["record", key], true);
    const text = isScalar(node) && node.value !== null ? (node.source ?? String(node.value)) : "";
    return [key, text] as const;
  });
  return Object.fromEntries(found.filter(([, text]) => text !== ""));
}

/** Every value as text, in quotes where it would be read as a number. */
function writeRecord(page: Document, record: Specimen): void {
  for (const key of RECORD) {
    if (record[key]) page.setIn(["record", key], record[key]);
    else if (page.hasIn(["record", key])) page.deleteIn(["record", key]);
  }
  const left = page.get("record");
  if (isMap(left) && left.items.length === 0) page.delete("record");
}

export const LINEAR = "linear";
export const AND = "+"; // between laws that a band has at once

/** The laws of a group; none: the spring alone. */
export function lawsOf(content: DeviceContent, group: string): string[] {
  const law = content.bands.find((band) => groupOf(band) === group)?.law ?? LINEAR;
  return law
    .split(AND)
    .map((each) => each.trim())
    .filter((each) => each !== LINEAR);
}

/** Values of several laws at once, each once. */
export function ownValues(laws: readonly BandLaw[]): BandLaw["values"] {
  const values = laws.flatMap((each) => each.values);
  return values.filter((each, k) => values.findIndex((other) => other.name === each.name) === k);
}

export function groupOf(band: Band): string {
  return band.group ?? band.name;
}

/** Bands of one group share their stiffness: where one says none, another's holds. */
export function stiffnessOf(content: DeviceContent, group: string): number | undefined {
  return content.bands.find((band) => groupOf(band) === group && band.stiffness_n_per_m !== undefined)?.stiffness_n_per_m;
}

export function groupsOf(content: DeviceContent): string[] {
  return [...new Set(content.bands.map(groupOf))];
}
