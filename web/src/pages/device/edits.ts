/** What can be done to a device: each gives a new one. A changed value is no longer ground truth. */

import { linkNamed, placeOn, stepOn } from "../../parts/place";
import type { RobotModel } from "../../api/robots";
import type { BandLaw } from "../../api/devices";
import { AND, groupOf, ownValues, type Band, type DeviceContent, type Specimen, type ViaPoint } from "./deviceFile";

const MICROMETRE = 1e-6;

export function withStiffness(device: DeviceContent, group: string, value: number): DeviceContent {
  const bands = device.bands.map((band) => (groupOf(band) === group ? { ...guessed(band), stiffness_n_per_m: value } : band));
  return { ...device, bands };
}

/** A tied group has one natural length. */
export function withLength(device: DeviceContent, name: string, value: number): DeviceContent {
  const group = groupOf(device.bands.find((band) => band.name === name) as Band);
  const tied = device.tied?.includes(group);
  const bands = device.bands.map((band) =>
    band.name === name || (tied && groupOf(band) === group) ? { ...guessed(band), natural_length_m: value } : band,
  );
  return { ...device, bands };
}

/** The group pulls by another law; values are in the order of the law's own. */
export function withLaw(device: DeviceContent, group: string, laws: readonly BandLaw[]): DeviceContent {
  const values = Object.fromEntries(ownValues(laws).map((each) => [each.name, each.default ?? each.typical]));
  const bands = device.bands.map((band) => {
    if (groupOf(band) !== group) return band;
    const { law: _, law_values: had, ...rest } = guessed(band);
    if (laws.length === 0) return rest;
    const kept = Object.keys(values).map((name) => [name, had?.[name] ?? values[name]]);
    return { ...rest, law: laws.map((each) => each.name).join(AND), law_values: Object.fromEntries(kept) as Record<string, number> };
  });
  return { ...device, bands };
}

export function withLawValue(device: DeviceContent, group: string, name: string, value: number): DeviceContent {
  const bands = device.bands.map((band) =>
    groupOf(band) === group ? { ...guessed(band), law_values: { ...band.law_values, [name]: value } } : band,
  );
  return { ...device, bands };
}

export function withPoint(device: DeviceContent, name: string, k: number, point: ViaPoint): DeviceContent {
  return withPoints(device, name, (points) => points.map((each, j) => (j === k ? point : each)));
}

/** The point stays where it is, its numbers become those of the other link's frame. */
export function withLink(device: DeviceContent, model: RobotModel, name: string, k: number, link: string): DeviceContent {
  const point = device.bands.find((band) => band.name === name)?.via_points[k];
  const [from, to] = [linkNamed(model, point?.link ?? ""), linkNamed(model, link)];
  if (!point || !to) return device;
  const place = from ? placeOn(from, point.xyz) : point.xyz;
  const xyz = from ? stepOn(to, place.map((each, axis) => each - (to.at[axis] ?? 0))) : point.xyz;
  return withPoint(device, name, k, { link, xyz: tidy(xyz) });
}

/** A new point between this and the next one; after the last, a little further on. */
export function withNewPoint(device: DeviceContent, model: RobotModel, name: string, k: number): DeviceContent {
  const points = device.bands.find((band) => band.name === name)?.via_points ?? [];
  const [here, next] = [points[k], points[k + 1]];
  const [link, onward] = [linkNamed(model, here?.link ?? ""), linkNamed(model, next?.link ?? "")];
  if (!here || !link) return device;
  const from = placeOn(link, here.xyz);
  const to = next && onward ? placeOn(onward, next.xyz) : ([from[0], from[1], from[2] - 0.1] as const);
  const middle = from.map((each, axis) => (each + (to[axis] ?? 0)) / 2 - (link.at[axis] ?? 0));
  const added = { link: here.link, xyz: tidy(stepOn(link, middle)) };
  return withPoints(device, name, (all) => [...all.slice(0, k + 1), added, ...all.slice(k + 1)]);
}

export function withoutPoint(device: DeviceContent, name: string, k: number): DeviceContent {
  return withPoints(device, name, (points) => points.filter((_, j) => j !== k));
}

export function withRecord(device: DeviceContent, key: keyof Specimen, text: string): DeviceContent {
  const { [key]: _, ...rest } = device.record;
  return { ...device, record: text.trim() === "" ? rest : { ...rest, [key]: text } };
}

export function tidy(xyz: readonly number[]): [number, number, number] {
  const [x = 0, y = 0, z = 0] = xyz.map((each) => Math.round(each / MICROMETRE) * MICROMETRE).map((each) => Number(each.toFixed(6)));
  return [x, y, z];
}

function withPoints(device: DeviceContent, name: string, change: (points: ViaPoint[]) => ViaPoint[]): DeviceContent {
  const bands = device.bands.map((band) => (band.name === name ? { ...band, via_points: change(band.via_points) } : band));
  return { ...device, bands };
}

function guessed(band: Band): Band {
  const { ground_truth: _, ...rest } = band;
  return rest;
}
