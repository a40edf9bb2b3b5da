/** What differs between a device and the one it was made of, in sentences. */

import { figure, NONE } from "../../parts/digits";
import { groupOf, groupsOf, LINEAR, lawsOf, RECORD, stiffnessOf, type DeviceContent, type Specimen } from "./deviceFile";

export const SPECIMEN: Record<keyof Specimen, string> = {
  model: "Model",
  size: "Size",
  serial: "Serial number",
  straps: "Strap settings",
  pretension: "Pre-tension",
  garment: "Garment below",
};

export function differences(before: DeviceContent, after: DeviceContent): string[] {
  const found = [];
  for (const group of groupsOf(after)) {
    const [was, is] = [stiffnessOf(before, group), stiffnessOf(after, group)];
    if (was !== is) found.push(`Stiffness of ${group}: ${figure(was)} → ${figure(is)} N/m`);
  }
  for (const group of groupsOf(after)) {
    const [was, is] = [before, after].map((each) => lawWords(each, group));
    if (was !== is) found.push(`Law of ${group}: ${was} → ${is}`);
  }
  for (const band of after.bands) {
    const old = before.bands.find((each) => each.name === band.name);
    if (!old) continue;
    if (old.natural_length_m !== band.natural_length_m) {
      found.push(`Natural length of ${band.name}: ${figure(old.natural_length_m)} → ${figure(band.natural_length_m)} m`);
    }
    const [were, are] = [old.via_points.length, band.via_points.length];
    if (were !== are) {
      found.push(`Via points of ${band.name}: ${were} → ${are}`);
      continue;
    }
    band.via_points.forEach((point, k) => {
      const last = old.via_points[k];
      if (last?.link !== point.link) found.push(`Via point ${k + 1} of ${band.name} is on ${point.link} instead of ${last?.link}`);
      else if (last.xyz.some((each, axis) => each !== point.xyz[axis])) {
        const moved = Math.hypot(...point.xyz.map((each, axis) => each - (last.xyz[axis] ?? 0)));
        found.push(`Via point ${k + 1} of ${band.name} moved by ${figure(1000 * moved, 3)} mm`);
      }
    });
  }
  const truths = after.bands.filter((band) => !band.ground_truth && before.bands.find((each) => each.name === band.name)?.ground_truth);
  if (truths.length > 0) found.push(`No longer marked as ground truth: ${truths.map((band) => band.name).join(", ")}`);
  for (const key of RECORD) {
    const [was, is] = [before.record[key], after.record[key]];
    if (was !== is) found.push(`${SPECIMEN[key]}: ${was ?? NONE} → ${is ?? NONE}`);
  }
  return found;
}

function lawWords(device: DeviceContent, group: string): string {
  const band = device.bands.find((each) => groupOf(each) === group);
  const values = Object.entries(band?.law_values ?? {}).map(([name, value]) => `${name} ${figure(value)}`);
  const named = lawsOf(device, group).join(" and ") || LINEAR;
  return values.length > 0 ? `${named} (${values.join(", ")})` : named;
}

/** What the service would refuse anyway; null: nothing. */
export function hindrance(device: DeviceContent): string | null {
  for (const band of device.bands) {
    const stiffness = stiffnessOf(device, groupOf(band));
    if (stiffness !== undefined && !(stiffness > 0)) return `The stiffness of ${groupOf(band)} must be above 0 N/m.`;
    if (band.natural_length_m !== undefined && !(band.natural_length_m > 0)) {
      return `The natural length of ${band.name} must be above 0 m.`;
    }
    const far = band.via_points.findIndex(({ xyz }) => xyz.some((each) => !Number.isFinite(each) || Math.abs(each) > 100));
    if (far >= 0) return `Via point ${far + 1} of ${band.name} has a coordinate that is missing or beyond 100 m.`;
  }
  return null;
}
