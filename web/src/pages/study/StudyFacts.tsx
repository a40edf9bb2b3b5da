import { count } from "../../parts/size";
import type { StudySummary } from "./summary";

/** What a study holds, in one line: robot, wears, logs. */
export function StudyFacts({ summary: { robot, devices = [], logs = [] } }: { summary: StudySummary }) {
  const facts = [];
  if (robot?.name) facts.push(`${robot.name}, ${count(robot.joints?.length ?? 0, "joint")}`);
  facts.push(devices.length ? `wears ${devices.map((each) => each.name).join(" and ")}` : "no device");
  facts.push(count(logs.length, "log"));
  return <>{facts.join(" · ")}</>;
}
