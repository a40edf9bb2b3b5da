/** payload.yaml as it is put together: what is not said yet is undefined, or an empty name. */

import { parse, stringify } from "yaml";

import type { Look, Urdf } from "../../../api/payloadDrafts";

export type Role = "postures" | "excitation" | "test" | "contact";
export type LogEntry = { file: string[]; role: Role; span?: (number | undefined)[]; each_row?: boolean };
export type Cap = { axis: "x" | "y" | "z"; theta_deg?: (number | undefined)[]; phi_deg?: (number | undefined)[] };
export type PlanContent = {
  joints: string[];
  home: Record<string, number | undefined>;
  acceleration: Record<string, number | undefined>;
  position?: Record<string, (number | undefined)[]>;
  velocity?: Record<string, number | undefined>;
  torque?: Record<string, number | undefined>;
  payload: { mass_kg?: number; centre_m: (number | undefined)[]; size_m: (number | undefined)[] };
  workspace?: Cap[];
  postures?: Record<string, unknown>;
  excitation?: Record<string, unknown>;
};
export type Content = {
  version: 1;
  name?: string;
  gravity?: (number | undefined)[];
  sensor: {
    frame?: string;
    sees?: string;
    axes?: string;
    wrench: string[];
    force_unit?: string;
    moment_unit?: string;
    noise: { force_n?: number; moment_nm?: number };
    range?: { force_n: (number | undefined)[]; moment_nm: (number | undefined)[] };
  };
  pose: {
    urdf?: string;
    base_link?: string;
    joints?: Record<string, string>;
    angle_unit?: string;
    rotation?: string[];
    quaternion?: string[];
    quaternion_order?: string;
    position?: string[];
    position_unit?: string;
    noise_rad?: number;
    noise_m?: number;
  };
  time: { column: string; unit: string };
  imu?: { acceleration: string[]; unit?: string; delay_s?: number };
  logs: LogEntry[];
  settings?: Record<string, unknown>;
  plan?: PlanContent;
  ground_truth?: { mass_kg?: number };
};
export type Way = "joints" | "rotation" | "quaternion";

export const WRENCH = ["fx", "fy", "fz", "mx", "my", "mz"];
export const XYZ = ["x", "y", "z"] as const;
const ENTRIES = [1, 2, 3].flatMap((row) => [1, 2, 3].map((column) => `r${row}${column}`));

export const EMPTY: Content = {
  version: 1,
  gravity: [0, 0, -9.81],
  sensor: { wrench: WRENCH, force_unit: "N", moment_unit: "Nm", axes: "sensor", noise: {} },
  pose: { joints: {}, angle_unit: "rad" },
  time: { column: "t", unit: "s" },
  logs: [],
};

export function textOf(content: Content): string {
  return stringify(said(content), { lineWidth: 120, flowCollectionPadding: false });
}

/** A payload.yaml that was written, by whomever. */
export function contentOf(text: string): Content {
  const read = parse(text) as Partial<Content>;
  const logs = (read.logs ?? []).map((log) => ({ ...log, file: [log.file].flat() }));
  return {
    ...EMPTY,
    ...read,
    sensor: { ...EMPTY.sensor, ...read.sensor },
    pose: { ...read.pose },
    time: { ...EMPTY.time, ...read.time },
    logs,
  };
}

/** Without the keys that nothing is said of, so that the service tells what is missing; places in a list stay. */
function said(value: unknown): unknown {
  if (Array.isArray(value)) return value.map((each) => (each === undefined ? null : said(each)));
  if (typeof value !== "object" || value === null) return value;
  const kept = Object.entries(value).filter(([, each]) => each !== undefined && each !== "" && !isEmpty(each));
  return Object.fromEntries(kept.map(([key, each]) => [key, said(each)]));
}

function isEmpty(value: unknown): boolean {
  if (Array.isArray(value)) return value.length === 0;
  return typeof value === "object" && value !== null && Object.values(value).every((each) => each === undefined || each === "");
}

export function wayOf({ pose }: Content): Way {
  return pose.rotation ? "rotation" : pose.quaternion ? "quaternion" : "joints";
}

export function withWay(content: Content, way: Way, robot: Urdf | undefined): Content {
  const { noise_rad } = content.pose;
  if (way === "rotation") return { ...content, pose: { rotation: ENTRIES, noise_rad } };
  if (way === "quaternion") return { ...content, pose: { quaternion: ["qx", "qy", "qz", "qw"], quaternion_order: "xyzw", noise_rad } };
  const pose = { joints: {}, angle_unit: "rad", noise_rad };
  return robot ? ofRobot({ ...content, pose }, robot) : { ...content, pose };
}

/** With the URDF's joints and root; the sensor's frame only where one is called so. */
export function ofRobot(content: Content, robot: Urdf): Content {
  const names = Object.fromEntries(robot.joints.map(({ name }) => [name, content.pose.joints?.[name] ?? `q.${name}`]));
  const frames = robot.frames.filter((name) => /(^|[^a-z])(ft|f_t|sensor|wrench|force)/i.test(name));
  const known = robot.frames.includes(content.sensor.frame ?? "");
  const shortest = [...frames].sort((a, b) => a.length - b.length)[0] ?? "";
  const frame = known ? content.sensor.frame : frames.every((name) => name.startsWith(shortest)) ? frames.find((name) => name === shortest) : undefined;
  const base = robot.frames.includes(content.pose.base_link ?? "") ? content.pose.base_link : robot.fixed[0];
  return { ...content, sensor: { ...content.sensor, frame }, pose: { ...content.pose, urdf: robot.file, base_link: base, joints: names } };
}

/** What the columns' names say, where what is said by now is no column of any log. */
export function named(content: Content, look: Look): Content {
  const columns = look.logs.flatMap((log) => log.columns);
  const known = new Set(columns.map(({ name }) => name));
  if (known.size === 0) return content;
  const { sensor, pose, time } = content;
  const next = { ...content, sensor: { ...sensor, wrench: [...sensor.wrench] }, pose: { ...pose, ...(pose.joints && { joints: { ...pose.joints } }) }, time: { ...time } };
  for (const { name, suggestion } of columns) {
    if (!suggestion) continue;
    const { channel, unit } = suggestion;
    const [kind = "", of = "", axis = ""] = channel.split(".");
    if (channel === "t" && !known.has(time.column)) next.time = { column: name, unit };
    const joint = channel.slice(2);
    if (kind === "q" && pose.joints && joint in pose.joints && !known.has(pose.joints[joint] ?? "")) {
      next.pose.joints![joint] = name;
      next.pose.angle_unit = unit;
    }
    const k = kind === "ft" && of === "sensor" ? WRENCH.indexOf(axis) : -1;
    if (k >= 0 && !known.has(sensor.wrench[k] ?? "")) {
      next.sensor.wrench[k] = name;
      next.sensor[k < 3 ? "force_unit" : "moment_unit"] = unit;
    }
  }
  return next;
}

/** Where nothing is planned yet: the last three joints move, the others stay at zero. */
export function newPlan(content: Content): PlanContent {
  const joints = Object.keys(content.pose.joints ?? {});
  const moved = joints.slice(-3);
  return {
    joints: moved,
    home: Object.fromEntries(joints.map((name) => [name, 0])),
    acceleration: Object.fromEntries(moved.map((name) => [name, 3])),
    payload: { centre_m: [0, 0, 0], size_m: [undefined, undefined, undefined] },
    workspace: [],
  };
}
