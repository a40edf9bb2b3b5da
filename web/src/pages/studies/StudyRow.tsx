import { Anchor, Group, Progress, Text } from "@mantine/core";
import { Link } from "react-router";

import type { Study } from "../../api/studies";
import { Row } from "../../parts/Rows";
import { StateBadge } from "../../parts/StateBadge";
import { When } from "../../parts/When";
import { factsOf } from "./facts";
import styles from "./StudyList.module.css";

export function StudyRow({ study }: { study: Study }) {
  const job = study.latest_job;
  const running = job?.state === "running";
  const words = (
    <>
      <Anchor component={Link} to={`/studies/${study.id}`} fw={600}>
        {study.name}
      </Anchor>
      <Text size="sm" c="dimmed">
        {factsOf(study).join(" · ")}
      </Text>
      {job?.state === "failed" && job.reason && (
        <Text size="sm" lineClamp={2} className={styles.reason}>
          {job.reason}
        </Text>
      )}
    </>
  );
  return (
    <Row words={words}>
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
    </Row>
  );
}
