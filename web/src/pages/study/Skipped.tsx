import { Text } from "@mantine/core";

import { Empty } from "../../parts/Empty";
import type { Results } from "./results";
import { STEPS } from "./words";

/** In place of a step's results: why there are none, and what would make some. */
export function Skipped({ results, step, advice }: { results: Results; step: string; advice: string }) {
  const reason = results.steps.find((each) => each.step === step)?.reason;
  return (
    <Empty title={`${STEPS[step]?.[0] ?? step}: not made`}>
      <Text>{reason ? `This step was skipped: ${reason}.` : "This step found nothing to compare."}</Text>
      <Text c="dimmed">{advice}</Text>
    </Empty>
  );
}
