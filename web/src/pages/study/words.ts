/** Names of the service's identifiers, in a person's words. */

export const STEPS: Record<string, [string, string]> = {
  identify: ["Identification", "masses, motors, friction of the robot"],
  discrepancy: ["Missing effects", "what the model lacks"],
  support: ["Supporting torque", "joint by joint, A and B"],
  stiffness: ["Bands", "stiffness and natural length"],
};

export const PAYLOAD_STEPS: Record<string, [string, string]> = {
  postures: ["Postures", "mass, centre, zero at rest"],
  kinematics: ["Motion", "how the sensor moves in each log"],
  excitation: ["Excitation", "inertia, and all that motion tells"],
  missing: ["Missing effects", "what a rigid body lacks"],
  contact: ["Contact", "what touched, what is left"],
};

export const KINDS: Record<string, string> = {
  evaluate: "whole evaluation",
  support: "up to the supporting torque",
  stiffness: "up to the bands",
  whatif: "another device",
  payload: "identification",
  payload_plan: "plan",
};

export const POOLED: Record<string, string> = {
  base_moment: "Base moment",
  trunk_torque: "Torque of the trunk’s joints",
  joint_torque: "Torque of all joints",
  joint_force: "Force of sliding joints",
  sensor_force: "Forces of the sensors",
  sensor_moment: "Moments of the sensors",
};

/** `Stribeck friction at torso_pitch`; of results that hold no words yet, the identifier. */
export function titleOf({ title, effect }: { title?: string | null; effect: string }): string {
  return capital(title ?? effect);
}

export function capital(text: string): string {
  return text.slice(0, 1).toUpperCase() + text.slice(1);
}

export function duration(seconds: number): string {
  const whole = Math.max(Math.round(seconds), 0);
  if (whole < 60) return `${whole} s`;
  if (whole < 3600) return `${Math.floor(whole / 60)} min ${whole % 60} s`;
  return `${Math.floor(whole / 3600)} h ${Math.floor((whole % 3600) / 60)} min`;
}
