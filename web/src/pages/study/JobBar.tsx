import { Button, Group, Progress, Select, Text } from "@mantine/core";
import { IconPlayerStop, IconRefresh } from "@tabler/icons-react";
import { useEffect, useState } from "react";

import { isActive } from "../../api/studies";
import { ForMembers } from "../../parts/ForMembers";
import { ProblemBox } from "../../parts/ProblemBox";
import { StateBadge } from "../../parts/StateBadge";
import { useDeed } from "../../parts/useDeed";
import { useCancel, useRetry, type Job } from "./jobs";
import styles from "./JobBar.module.css";
import { phrase } from "./stages";
import { capital, duration, KINDS } from "./words";

type Props = { job: Job; jobs: Job[]; onChoose: (jobId: string) => void };

const STATES: Record<Job["state"], string> = {
  queued: "waiting",
  running: "running",
  succeeded: "done",
  failed: "failed",
  cancelled: "cancelled",
};

/** Which job is looked at, how it stands, and what can be done with it. */
export function JobBar({ job, jobs, onChoose }: Props) {
  const cancel = useCancel(job.id);
  const retry = useRetry(job.id);
  const { start, busy, error } = useDeed();
  const again = async () => onChoose((await retry.mutateAsync()).id);
  const ended = job.state === "failed" || job.state === "cancelled";
  return (
    <div className={styles.bar}>
      <Group gap="sm" justify="space-between" align="center">
        <Select
          aria-label="Job"
          size="sm"
          className={styles.choice}
          allowDeselect={false}
          data={jobs.map((each, k) => ({ value: each.id, label: jobWords(each, k === 0) }))}
          value={job.id}
          onChange={(id) => id && onChoose(id)}
        />
        <Group gap="sm">
          <StateBadge state={job.state} />
          <Timing job={job} />
          <ForMembers>{isActive(job.state) && (
            <Button
              size="xs"
              variant="default"
              leftSection={<IconPlayerStop size={16} aria-hidden />}
              loading={cancel.isPending || job.cancel_requested}
              onClick={() => cancel.mutate()}
            >
              Cancel
            </Button>
          )}
          {ended && (
            <Button
              size="xs"
              leftSection={<IconRefresh size={16} aria-hidden />}
              loading={busy}
              onClick={() => start(again)}
            >
              Run it again
            </Button>
          )}</ForMembers>
        </Group>
      </Group>
      {isActive(job.state) && <Live job={job} />}
      {(cancel.error ?? error) !== null && <ProblemBox error={cancel.error ?? error} />}
    </div>
  );
}

/** Place in the queue, or how far it is. */
function Live({ job }: { job: Job }) {
  const share = Math.round(100 * job.progress);
  return (
    <div>
      {job.state === "running" && <Progress value={share} size="sm" my={6} aria-label="Progress of the job" />}
      <Text size="sm" role="status">
        {job.cancel_requested
          ? "It stops within a second."
          : job.state === "queued"
            ? `In the queue: ${job.place ?? "waiting"}.`
            : `${share} %. ${capital(phrase(job)) || "Starting"}`}
      </Text>
    </div>
  );
}

function Timing({ job }: { job: Job }) {
  const now = useNow(job.state === "running");
  if (!job.started_at) return null;
  const end = job.finished_at ? Date.parse(job.finished_at) : now;
  const words = duration((end - Date.parse(job.started_at)) / 1000);
  return (
    <Text size="sm" c="dimmed">
      {job.finished_at ? `took ${words}` : `for ${words}`}
    </Text>
  );
}

function useNow(ticking: boolean): number {
  const [now, setNow] = useState(Date.now);
  useEffect(() => {
    if (!ticking) return;
    setNow(Date.now());
    const clock = window.setInterval(() => setNow(Date.now()), 1000);
    return () => window.clearInterval(clock);
  }, [ticking]);
  return now;
}

function jobWords(job: Job, newest: boolean): string {
  const at = new Date(job.created_at).toLocaleString(undefined, { dateStyle: "medium", timeStyle: "medium" });
  return `${at} · ${KINDS[job.kind] ?? job.kind} · ${STATES[job.state]}${newest ? " (newest)" : ""}`;
}
