import { Group, Progress, Text } from "@mantine/core";
import type { Study } from "../../api/studies";
import { StateBadge } from "../../parts/StateBadge";
import { ThingRow } from "../../parts/ThingList";
import { When } from "../../parts/When";
import { factsOf } from "./facts";
import styles from "./StudyList.module.css";

export function StudyRow({ study }: { study: Study }) {
  const job = study.latest_job;
  const running = job?.state === "running";
  return (
    <ThingRow to={`/studies/${study.id}`} name={study.name} facts={factsOf(study).join(" · ")} job={job ?? null}>
      <div className={styles.state}>
        <Group gap="xs" justify="flex-end">
          {running && <Text size="sm">{Math.round(job.progress * 100)} %</Text>}
          <StateBadge state={job?.state} />
        </Group>
        {running && <Progress value={job.progress * 100} size="sm" aria-label={`Progress of ${study.name}`} />}
        <Text size="sm" c="dimmed" ta="right">
          <When at={study.created_at} />
        </Text>
      </div>
    </ThingRow>
  );
}
