/** Why the service did not do what it was asked: its RFC 9457 problem, that it did not answer at all, or that a guard in
 * front of it answered in its place. */

import type { components } from "./schema";

export type ProblemError = components["schemas"]["ProblemError"];
export type Problem = Omit<components["schemas"]["Problem"], "instance"> & { instance?: string | null };

const GUARD = "about:guard";

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
    return !this.signedOut && [0, 502, 503, 504].includes(this.status);
  }

  /** Whether a guard in front of the service wants to know who asks. */
  get signedOut(): boolean {
    return this.problem.type === GUARD;
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

/** The answer, where it is the service's own. A guard says 401 or 403, shows a page of its own, or the way to one: the
 * service itself never redirects, and answers no script in HTML. */
export function fromService(response: Response): Response {
  const kind = response.headers.get("content-type") ?? "";
  const refused = response.status === 401 || (response.status === 403 && !kind.startsWith("application/problem+json"));
  const led = response.type === "opaqueredirect" || (response.ok && kind.startsWith("text/html"));
  if (refused || led) throw signedOut(response.status);
  return response;
}

function signedOut(status: number): Refusal {
  const detail =
    status === 403
      ? "Your session has expired, you are not signed in, or you may not do this. Sign in again, above on this page."
      : "Your session has expired, or you are not signed in. Sign in again, above on this page.";
  return new Refusal({ type: GUARD, title: "You are not signed in", status, detail, errors: [] });
}
