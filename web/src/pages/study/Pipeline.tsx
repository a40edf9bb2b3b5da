import { Text } from "@mantine/core";
import { IconAlertTriangle, IconCheck, IconCircle, IconCircleDashed, IconLoader2, IconMinus, IconPlayerStop } from "@tabler/icons-react";

import styles from "./Pipeline.module.css";
import type { Stage, StageState } from "./stages";

const LOOKS: Record<StageState, [typeof IconCheck, string]> = {
  done: [IconCheck, "done"],
  now: [IconLoader2, "running"],
  failed: [IconAlertTriangle, "failed here"],
  stopped: [IconPlayerStop, "stopped here"],
  waiting: [IconCircle, "waiting"],
  unreached: [IconCircleDashed, "not reached"],
  skipped: [IconMinus, "skipped"],
};

/** The steps of a job from left to right; a skipped one says why. */
export function Pipeline({ stages }: { stages: Stage[] }) {
  return (
    <ol className={styles.stages} aria-label="Steps">
      {stages.map(({ key, name, about, state, reason }) => {
        const [Icon, words] = LOOKS[state];
        return (
          <li key={key} className={styles.stage} data-state={state} aria-current={state === "now" ? "step" : undefined}>
            <Icon size={18} aria-hidden className={styles.icon} />
            <div>
              <Text size="sm" fw={600} component="span">
                {name}
              </Text>{" "}
              <Text size="xs" component="span" c="dimmed">
                {words}
              </Text>
              <Text size="xs" c="dimmed">
                {reason || about}
              </Text>
            </div>
          </li>
        );
      })}
    </ol>
  );
}
