/** The verdict of the search for missing effects in plain sentences, as the report says it. */

import { significant } from "../../parts/digits";
import type { Discrepancy, Excess, Finding, Results } from "./results";
import { channelWords, lower, pointOf, titleOf } from "./words";

const NAMED = 3; // effects that the sentence names; it counts the others

export function verdictOf({ discrepancy, identification }: Results): string {
  if (!discrepancy) return "";
  if (discrepancy.findings.length) return effects(discrepancy);
  const tried = `none of ${counted(discrepancy.candidates)} candidates`;
  if (discrepancy.verdict === "unexplained") {
    const worst = furthest(discrepancy.unexplained.length ? discrepancy.unexplained : discrepancy.located);
    const where = worst ? `, most at ${channelWords(worst.channel)} (${excess(worst)})` : "";
    return `Measurement and model disagree by more than noise explains${where}, and ${tried} explains it on held-out logs.`;
  }
  if (!identification.validation.some((fit) => fit.held_out))
    return "Whether the model lacks an effect cannot be told: no log was held out.";
  return `No effect is missing as far as these logs can show: ${tried} surely explains anything beyond noise.`;
}

function effects({ findings }: Discrepancy): string {
  const [first] = findings;
  if (first && findings.length === 1) {
    const { channel, unit, rmse_before, rmse_after, noise_floor } = first.held_out;
    const verb = (rmse_after ?? 0) > (rmse_before ?? 0) ? "rises" : "falls";
    const change = `${verb} from ${significant(rmse_before)} to ${significant(rmse_after)} ${unit} RMSE`;
    return `The identified model does not know of ${lower(titleOf(first))}. With it the error of ${channelWords(channel)} ${judgedOn(first)} ${change} (noise floor ${significant(noise_floor)}).`;
  }
  const named = findings.slice(0, NAMED).map((each) => `${lower(titleOf(each))} (${changeOf(each)})`);
  const more = findings.length - named.length;
  const words = more ? [...named, `${more} more`] : named;
  const list = `${words.slice(0, -1).join(", ")} and ${words.at(-1)}`;
  return `The identified model does not know of ${findings.length} effects: ${list}. The errors are those on held-out logs, without and with the effect.`;
}

/** The logs that the errors are about: held-out ones, or the one log that has the effect. */
export function judgedOn({ held_out: held }: Finding): string {
  return held.log ? `in ${held.log}, the one log that has it,` : "on held-out logs";
}

/** `2.25 → 1.08 N·m, noise floor 1.02`; with the channel where it is not named like the place. */
function changeOf({ held_out: held, where }: Finding): string {
  const name = channelWords(held.channel);
  const change = `${significant(held.rmse_before)} → ${significant(held.rmse_after)} ${held.unit}, noise floor ${significant(held.noise_floor)}`;
  return name === pointOf(where) ? change : `${name}: ${change}`;
}

/** What is above the noise after all that was named. */
export function leftOf({ unexplained }: Discrepancy): string {
  const worst = furthest(unexplained);
  if (!worst) return "Nothing is left above the noise.";
  const many = unexplained.length === 1 ? "One channel stays" : `${unexplained.length} channels stay`;
  return `${many} above the noise, most at ${channelWords(worst.channel)} (${excess(worst)}).`;
}

function furthest(found: Excess[]): Excess | undefined {
  return [...found].sort((one, two) => (two.z ?? -Infinity) - (one.z ?? -Infinity))[0];
}

function excess({ rmse, unit, noise_floor }: Excess): string {
  return `${significant(rmse)} ${unit} RMSE, noise floor ${significant(noise_floor)}`;
}

export function counted(number: number): string {
  return number.toLocaleString("en").replaceAll(",", "\u202f");
}
