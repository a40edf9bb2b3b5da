/** Plots of a log as it was read: its channels are `q.elbow`, `ft.wrist.fx`, `acc.x`, `base.qw`. */

export type RawLine = { key: string; title: string; group: string; words: string };

const OF_JOINT: Record<string, [title: string, group: string]> = {
  q: ["Position", "Joint position"],
  dq: ["Velocity", "Joint velocity"],
  ddq: ["Acceleration", "Joint acceleration"],
  i: ["Motor current", "Motor current"],
  tau: ["Torque", "Joint torque"],
  temp: ["Temperature", "Temperature"],
};
const OF_BODY: Record<string, [title: string, group: string]> = {
  acc: ["Acceleration of the IMU", "IMU"],
  gyro: ["Turning rate of the IMU", "IMU"],
};
const WRENCH = /^ft\.(.+)\.([fm])([xyz])$/;

/** The plot of a joint's channel; null where it is none. */
export function ofJoint(name: string): Omit<RawLine, "words"> | null {
  const dot = name.indexOf(".");
  const found = OF_JOINT[name.slice(0, dot)];
  return found ? { key: name, title: `${found[0]} of ${name.slice(dot + 1)}`, group: found[1] } : null;
}

/** null: of no kind that a log has. words: what a joint's line is called. */
export function rawLine(name: string, words = "As logged"): RawLine | null {
  const dot = name.indexOf(".");
  const [kind, rest] = [name.slice(0, dot), name.slice(dot + 1)];
  const joint = ofJoint(name);
  if (joint) return { ...joint, words };
  const body = OF_BODY[kind];
  if (body) return { key: kind, title: body[0], group: body[1], words: rest };
  const wrench = WRENCH.exec(name);
  if (wrench) {
    const [, sensor = "", sort = "", axis = ""] = wrench;
    return { key: `ft.${sensor}.${sort}`, title: `${sort === "f" ? "Force" : "Moment"} of ${sensor}`, group: "Sensors", words: axis };
  }
  if (kind !== "base") return null;
  const turn = rest.startsWith("q");
  return { key: turn ? "base.turn" : "base.place", title: turn ? "Orientation of the base" : "Position of the base", group: "Base", words: rest };
}
