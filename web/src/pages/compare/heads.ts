/** Names of jobs and approaches as column heads. */

import type { Comparison } from "../../api/compare";

export const APPROACHES: Record<string, string> = {
  A: "A: without − with",
  B: "B: model − measured",
  paired: "Paired: B with − B without",
  prior: "B with the maker’s values",
  band_model: "Band model",
};
export const ORDER = ["A", "B", "paired", "prior", "band_model"];

export function approachWords(approach: string): string {
  return APPROACHES[approach] ?? approach;
}

/** Where several jobs stand side by side. */
export function approachShort(approach: string): string {
  return { A: "A", B: "B", paired: "Paired", prior: "B, maker’s", band_model: "Model" }[approach] ?? approach;
}

/** The study's name, numbered where two jobs share it. */
export function jobNames(comparison: Comparison): string[] {
  const names = comparison.jobs.map((job) => job.name);
  return names.map((name, k) => (names.indexOf(name) === names.lastIndexOf(name) ? name : `${name} (${k + 1})`));
}

export function approachesOf(rows: { approach: string }[]): string[] {
  const found = [...new Set(rows.map((row) => row.approach))];
  const rank = (approach: string) => (ORDER.includes(approach) ? ORDER.indexOf(approach) : ORDER.length);
  return found.sort((a, b) => rank(a) - rank(b));
}

/** Whether the jobs of a row show different things; with one job nothing can. */
export function differs(shown: (string | null)[]): boolean {
  return shown.some((each) => each !== shown[0]);
}
