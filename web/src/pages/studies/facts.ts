/** What a study's summary says, in a few words. */

import type { Study } from "../../api/studies";
import { count } from "../../parts/size";

type Summary = {
  robot?: { name?: string; joints?: unknown[]; base?: string };
  logs?: unknown[];
  devices?: { name?: string }[];
};

export function factsOf(study: Study): string[] {
  const { robot, logs = [], devices = [] } = study.summary as Summary;
  const facts = [];
  if (robot?.name) facts.push(robot.name);
  if (robot?.joints) facts.push(count(robot.joints.length, "joint"));
  if (logs.length) facts.push(count(logs.length, "log"));
  const worn = devices.flatMap(({ name }) => (name ? [name] : []));
  if (worn.length) facts.push(`wears ${worn.join(" and ")}`);
  return facts;
}
