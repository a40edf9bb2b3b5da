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

/** null: of no kind that a log has. */
export function rawLine(name: string): RawLine | null {
  const dot = name.indexOf(".");
  const [kind, rest] = [name.slice(0, dot), name.slice(dot + 1)];
  const joint = OF_JOINT[kind];
  if (joint) return { key: name, title: `${joint[0]} of ${rest}`, group: joint[1], words: "As logged" };
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
