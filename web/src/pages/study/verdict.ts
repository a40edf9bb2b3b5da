/** The verdict of the search for missing effects in plain sentences, as the report says it. */

import { significant } from "../../parts/digits";
import type { Discrepancy, Excess, Results } from "./results";
import { channelWords, lower, titleOf } from "./words";

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
  const names = findings.map((each) => lower(titleOf(each)));
  const changes = findings.map(({ held_out: held }) => {
    const verb = (held.rmse_after ?? 0) > (held.rmse_before ?? 0) ? "rises" : "falls";
    const change = `${verb} from ${significant(held.rmse_before)} to ${significant(held.rmse_after)} ${held.unit} RMSE`;
    return `the error of ${channelWords(held.channel)} on held-out logs ${change} (noise floor ${significant(held.noise_floor)})`;
  });
  if (names.length === 1) return `The identified model lacks ${names[0]}. With it ${changes[0]}.`;
  return `The identified model lacks ${names.length} effects: ${names.join("; ")}. With them, ${changes.join("; ")}.`;
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
