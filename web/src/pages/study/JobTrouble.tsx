import { Alert, Text } from "@mantine/core";
import { IconInfoCircle } from "@tabler/icons-react";

import { ProblemBox } from "../../parts/ProblemBox";
import type { Job } from "./jobs";

/** Why a job did not succeed, or began anew, and what to do about it. */
export function JobTrouble({ job, onLog }: { job: Job; onLog: React.ReactNode }) {
  if (job.attempts > 1 && (job.state === "running" || job.state === "succeeded"))
    return (
      <Text size="sm" c="dimmed" mb="md">
        Begun {job.attempts} times: the process that computed it ended before it was done (killed, crashed or cut off), so all was computed again.
        Nothing that was handed in is lost. {onLog}
      </Text>
    );
  if (job.state === "cancelled")
    return (
      <Alert icon={<IconInfoCircle aria-hidden />} color="gray" variant="outline" title="This job was cancelled" mb="md">
        <Text size="sm">Nothing of it was kept. Run it again to get results.</Text>
      </Alert>
    );
  if (job.state !== "failed") return null;
  if (job.problem) {
    return (
      <div style={{ marginBottom: "var(--mantine-spacing-md)" }}>
        <ProblemBox problem={job.problem} />
        <Text size="sm" mt="xs">
          What was handed in cannot be evaluated as it is. Correct it, hand it in again, and run that. {onLog}
        </Text>
      </div>
    );
  }
  const detail = job.reason ?? "It ended without saying why.";
  return (
    <div style={{ marginBottom: "var(--mantine-spacing-md)" }}>
      <ProblemBox problem={{ type: "about:blank", title: "The job failed", status: 0, detail, errors: [] }} />
      <Text size="sm" mt="xs">
        {job.defect
          ? "This is a defect of the service, not of your data. Run it again once; if it fails the same way, report its log. "
          : "Your data were not changed. Running it again may help. "}
        {onLog}
      </Text>
    </div>
  );
}
