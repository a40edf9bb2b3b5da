/** A log in a few words, and the logs of a study to choose from. */

import { figure } from "../../parts/digits";
import type { SeriesFacts } from "../../plots/series";
import { ROLES, type StudyLog } from "./summary";
import { counted } from "./verdict";

export function factsOf(series: SeriesFacts, logs: StudyLog[]): string {
  const log = logs.find((each) => each.name === series.name);
  const facts = [
    log && (ROLES[log.role] ?? log.role),
    log?.motion && `motion ${log.motion}`,
    `${figure(series.end - series.start)} s`,
    `${counted(series.samples)} samples`,
    series.rate_hz !== null && `${figure(series.rate_hz)} Hz`,
  ];
  return facts.filter(Boolean).join(" · ");
}

export function optionsOf(names: string[], logs: StudyLog[]) {
  const roles = new Map(logs.map((log) => [log.name, log]));
  const groups = new Map<string, { value: string; label: string }[]>();
  for (const name of names) {
    const log = roles.get(name);
    const group = log ? [log.motion && `Motion ${log.motion}`, ROLES[log.role] ?? log.role].filter(Boolean).join(", ") : "Logs";
    groups.set(group, [...(groups.get(group) ?? []), { value: name, label: name }]);
  }
  return [...groups].map(([group, items]) => ({ group, items }));
}
