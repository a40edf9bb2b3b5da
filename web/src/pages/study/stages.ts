/** The pipeline of an evaluation as stages, and how far a job is in it.

A running job says its step before a colon: `support: comparing bend_normal_1`. What it says before the first step is
reading, after the last writing.
*/

import type { Job } from "./jobs";
import type { StudySummary } from "./summary";
import { STEPS } from "./words";

export type StageState = "done" | "now" | "failed" | "stopped" | "waiting" | "unreached" | "skipped";
export type Stage = { key: string; name: string; about: string; state: StageState; reason: string };

const ORDER = ["reading", "identify", "discrepancy", "support", "stiffness", "writing"] as const;
const WORDS: Record<string, [string, string]> = {
  ...STEPS,
  reading: ["Reading", "files, clocks, signals, motions"],
  writing: ["Results", "tables, series, report"],
};

export function stagesOf(job: Job, { steps = [] }: StudySummary): Stage[] {
  const at = placeOf(job);
  return ORDER.map((key, k) => {
    const [name, about] = WORDS[key] as [string, string];
    const skipped = steps.find((each) => each.step === key)?.skipped ?? (made(job.kind, key) ? null : "not asked for");
    return { key, name, about, state: skipped ? "skipped" : stateOf(job, key, k, at), reason: plainly(skipped ?? "") };
  });
}

function stateOf(job: Job, key: string, k: number, at: number): StageState {
  if (job.state === "succeeded") return "done";
  const ahead = job.state === "failed" || job.state === "cancelled" ? "unreached" : "waiting";
  if (job.state === "queued" || at < 0) return ahead;
  const present = k === at || (key === "stiffness" && ORDER[at] === "support");
  if (present) return job.state === "failed" ? "failed" : job.state === "cancelled" ? "stopped" : "now";
  return k < at ? "done" : ahead;
}

/** Index of the stage that the job is in, or was when it ended; -1 where it does not say. */
function placeOf({ message, progress, started_at }: Job): number {
  const step = /^(\w+): /.exec(message)?.[1] ?? "";
  const named = (ORDER as readonly string[]).indexOf(step);
  if (named >= 0) return named;
  if (message.startsWith("writing") || message === "done") return ORDER.length - 1;
  return started_at && progress <= 0.15 ? 0 : -1;
}

/** `support: comparing bend_1` -> `Supporting torque: comparing bend_1`. */
export function phrase(message: string): string {
  const [, step = "", rest = message] = /^(\w+): (.*)$/.exec(message) ?? [];
  const name = WORDS[step]?.[0];
  return name ? `${name}: ${rest}` : message;
}

/** Roles as study.yaml names them, in words. */
export function plainly(reason: string): string {
  return reason.replace("with role with_device", "with the device worn").replace("with role without_device", "without the device");
}

function made(kind: string, step: string): boolean {
  if (kind === "support") return step !== "discrepancy" && step !== "stiffness";
  return kind !== "stiffness" || step !== "discrepancy";
}
