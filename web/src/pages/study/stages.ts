/** The pipeline of an evaluation as stages, and how far a job is in it.

A job says itself at which stage it is.
*/

import type { Job } from "./jobs";
import type { StudySummary } from "./summary";
import { PAYLOAD_STEPS, STEPS } from "./words";

export type StageState = "done" | "now" | "failed" | "stopped" | "waiting" | "unreached" | "skipped";
export type Stage = { key: string; name: string; about: string; state: StageState; reason: string };

const ORDER = ["reading", "identify", "discrepancy", "support", "stiffness", "writing"] as const;
const WORDS: Record<string, [string, string]> = {
  ...STEPS,
  reading: ["Reading", "files, clocks, signals, motions"],
  writing: ["Results", "tables, series, report"],
};

export function stagesOf(job: Job, { steps = [] }: StudySummary): Stage[] {
  return ORDER.map((key) => {
    const [name, about] = WORDS[key] as [string, string];
    const skipped = steps.find((each) => each.step === key)?.skipped ?? (made(job.kind, key) ? null : "not asked for");
    return { key, name, about, state: skipped ? "skipped" : stateOf(job, key, ORDER), reason: skipped ?? "" };
  });
}

/** How a job stands to one of its stages. order: of all of them. */
export function stateOf(job: Job, key: string, order: readonly string[]): StageState {
  const [k, at] = [order.indexOf(key), placeOf(job, order)];
  if (job.state === "succeeded") return "done";
  const ahead = job.state === "failed" || job.state === "cancelled" ? "unreached" : "waiting";
  if (job.state === "queued" || at < 0) return ahead;
  const present = k === at || (key === "stiffness" && order[at] === "support");
  if (present) return job.state === "failed" ? "failed" : job.state === "cancelled" ? "stopped" : "now";
  return k < at ? "done" : ahead;
}

/** Index of the stage that the job is in, or was when it ended; -1 where it has not begun. */
function placeOf({ stage, started_at }: Job, order: readonly string[]): number {
  return stage ? order.indexOf(stage) : started_at ? 0 : -1;
}

/** `Supporting torque: comparing bend_1`. */
export function phrase({ stage, message }: { stage?: Job["stage"]; message: string }): string {
  const name = stage && (STEPS[stage] ?? PAYLOAD_STEPS[stage])?.[0];
  return name ? `${name}: ${message}` : message;
}

function made(kind: string, step: string): boolean {
  if (kind === "support") return step !== "discrepancy" && step !== "stiffness";
  return kind !== "stiffness" || step !== "discrepancy";
}
