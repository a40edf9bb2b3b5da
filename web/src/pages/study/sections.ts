/** The parts of a review, each with an address of its own below the study's. */

import { isEvaluation, type Answer } from "./results";
import type { Job } from "./jobs";

export type SectionKey =
  | "summary"
  | "identification"
  | "support"
  | "stiffness"
  | "disagreement"
  | "plots"
  | "scope"
  | "files"
  | "run";

export const NAMES: Record<SectionKey, string> = {
  summary: "Summary",
  identification: "Identification",
  support: "Support",
  stiffness: "Bands",
  disagreement: "Disagreement",
  plots: "Plots",
  scope: "Scope",
  files: "Files",
  run: "Run and logs",
};

export type SectionLink = { key: SectionKey; name: string };

/** A job that did not succeed has its run; one of another kind has no evaluation to show. */
export function sectionsFor(job: Job, results: Answer | undefined): SectionLink[] {
  const keys: SectionKey[] =
    job.state !== "succeeded"
      ? ["run"]
      : results && !isEvaluation(results)
        ? ["files", "run"]
        : ["summary", "identification", "support", "stiffness", "disagreement", "plots", "scope", "files", "run"];
  return keys.map((key) => ({ key, name: NAMES[key] }));
}
