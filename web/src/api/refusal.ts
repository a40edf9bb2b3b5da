/** Why the service did not do what it was asked: its RFC 9457 problem, or that it did not answer at all. */

import type { components } from "./schema";

export type ProblemError = components["schemas"]["ProblemError"];
export type Problem = Omit<components["schemas"]["Problem"], "instance"> & { instance?: string | null };

export class Refusal extends Error {
  readonly problem: Problem;

  constructor(problem: Problem) {
    super(problem.detail || problem.title);
    this.name = "Refusal";
    this.problem = problem;
  }

  /** 0: there was no answer. */
  get status(): number {
    return this.problem.status;
  }

  /** Whether the service is away, so that asking again may help. */
  get away(): boolean {
    return [0, 502, 503, 504].includes(this.status);
  }
}

export function noAnswer(): Refusal {
  const detail = "The service does not answer. Is it still running, and is this machine connected to it?";
  return new Refusal({ type: "about:blank", title: "No answer", status: 0, detail, errors: [] });
}

/** The problem of an answer: its own document, or what its status says (a proxy answers in HTML). */
export function refusalOf(status: number, words: string, body: unknown): Refusal {
  const said = body !== null && typeof body === "object" ? (body as Partial<Problem>) : {};
  const detail = `The service answered ${status} ${words}`.trim() + ".";
  return new Refusal({ type: "about:blank", title: words || "Refused", detail, errors: [], ...said, status });
}
