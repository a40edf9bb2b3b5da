/** The identification of a payload as stages, and how far a job is in it. */

import type { Payload } from "../../api/payloads";
import type { Job } from "../study/jobs";
import { stateOf, type Stage } from "../study/stages";
import { PAYLOAD_STEPS } from "../study/words";

const ORDER = ["reading", "postures", "kinematics", "excitation", "missing", "contact", "writing"];
const WORDS: Record<string, [string, string]> = {
  ...PAYLOAD_STEPS,
  reading: ["Reading", "files, clocks, signals"],
  writing: ["Results", "tables, report"],
};

export function stagesOf(job: Job, { summary: { logs } }: Payload): Stage[] {
  const roles = new Set(logs.map(({ role }) => role));
  const moved = roles.size > (roles.has("postures") ? 1 : 0);
  const without: Record<string, string | false> = {
    postures: !roles.has("postures") && "no postures were recorded",
    kinematics: !moved && "no motion was recorded",
    excitation: !roles.has("excitation") && "no excitation was recorded",
    missing: !roles.has("excitation") && "no excitation was recorded",
    contact: !roles.has("test") && !roles.has("contact") && "neither a test nor a contact was recorded",
  };
  return ORDER.map((key) => {
    const [[name, about], reason] = [WORDS[key]!, without[key]];
    return { key, name, about, state: reason ? "skipped" : stateOf(job, key, ORDER), reason: reason || "" };
  });
}
