/** What a column may measure, in words, and in which units. */

export type Quantity = "t" | "q" | "dq" | "ddq" | "i" | "tau" | "temp" | "acc" | "gyro" | "ft" | "base";

const FORCE = ["N", "kN", "mN", "kgf", "lbf"];
const MOMENT = ["Nm", "mNm", "kNm", "Ncm", "Nmm", "kgfcm", "kgfm", "lbfin", "lbfft"];

type Said = { words: string; units: string[]; of: "joint" | "xyz" | "wrench" | "pose" | null };

export const QUANTITIES: Record<Quantity, Said> = {
  t: { words: "Time", units: ["s", "ms", "us", "ns"], of: null },
  q: { words: "Joint position", units: ["rad", "deg", "mrad", "rev", "m", "mm", "cm", "um"], of: "joint" },
  dq: { words: "Joint velocity", units: ["rad/s", "deg/s", "rpm", "mrad/s", "rev/s", "m/s", "mm/s"], of: "joint" },
  ddq: { words: "Joint acceleration", units: ["rad/s^2", "deg/s^2", "m/s^2", "mm/s^2", "g", "mg"], of: "joint" },
  i: { words: "Motor current", units: ["A", "mA"], of: "joint" },
  tau: { words: "Joint torque", units: [...MOMENT, ...FORCE], of: "joint" },
  temp: { words: "Temperature", units: ["degC", "K"], of: "joint" },
  acc: { words: "Accelerometer", units: ["m/s^2", "g", "mg", "mm/s^2"], of: "xyz" },
  gyro: { words: "Gyro", units: ["rad/s", "deg/s", "mrad/s", "rpm", "rev/s"], of: "xyz" },
  ft: { words: "Force/torque sensor", units: [], of: "wrench" },
  base: { words: "Base pose", units: ["m", "mm", "cm", "1"], of: "pose" },
};
export const WRENCH = ["fx", "fy", "fz", "mx", "my", "mz"];
export const POSE = ["x", "y", "z", "qx", "qy", "qz", "qw"];
export const XYZ = ["x", "y", "z"];

export function unitsOf(quantity: Quantity, axis: string): string[] {
  if (quantity !== "ft") return QUANTITIES[quantity].units;
  return axis.startsWith("m") ? MOMENT : FORCE;
}

/** As a person writes it: N·m, µs, °. */
export function unitWords(unit: string): string {
  const words: Record<string, string> = { Nm: "N·m", mNm: "mN·m", kNm: "kN·m", kgfcm: "kgf·cm", kgfm: "kgf·m", lbfin: "lbf·in", lbfft: "lbf·ft", deg: "°", "deg/s": "°/s", "deg/s^2": "°/s²", us: "µs", um: "µm", degC: "°C", "1": "no unit" };
  return words[unit] ?? unit.replace("^2", "²");
}
