/** The verdict of the search for missing effects, as the server said it. Nothing is decided or worded here a second time. */

import type { Discrepancy, Results } from "./results";

const EARLIER = "This was evaluated by an earlier version of exogauge: its report says what the model lacks.";

export function verdictOf({ discrepancy }: Results): string {
  return discrepancy ? (discrepancy.sentence ?? EARLIER) : "";
}

/** What is above the noise after all that was named; empty where the verdict has said it. */
export function leftOf({ left_sentence, sentence }: Discrepancy): string {
  return left_sentence || (sentence ?? EARLIER);
}

export function counted(number: number): string {
  return number.toLocaleString("en").replaceAll(",", "\u202f");
}
