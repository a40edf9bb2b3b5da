import { Badge } from "@mantine/core";

import type { JobState } from "../api/studies";
import styles from "./StateBadge.module.css";

const WORDS: Record<JobState, [string, string]> = {
  queued: ["Waiting", "waiting"],
  running: ["Running", "running"],
  succeeded: ["Done", "done"],
  failed: ["Failed", "failed"],
  cancelled: ["Cancelled", "none"],
};

/** The state of a job in a word; without one, nothing was run yet. */
export function StateBadge({ state }: { state?: JobState | null }) {
  const [words, look] = state ? WORDS[state] : ["Not run yet", "none"];
  return (
    <Badge variant="default" tt="none" className={styles.badge} data-look={look}>
      {words}
    </Badge>
  );
}
