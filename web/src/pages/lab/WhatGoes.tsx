import { Code, Stack, Table, Text, Title } from "@mantine/core";
import { Link } from "react-router";

import { useRetention, type Retention } from "../../api/lab";
import { Loading } from "../../parts/Loading";
import { ProblemBox } from "../../parts/ProblemBox";
import { When } from "../../parts/When";
import { number, WideTable } from "../../parts/WideTable";

type Item = Retention["kinds"][number];

const WORDS: Record<Item["what"], { head: string; goes: string; stay: string }> = {
  studies: {
    head: "Studies, with jobs and results",
    goes: "so long after they were handed in and the last job ended",
    stay: "published, named by a plan, or a job waits or runs",
  },
  unused_logs: { head: "Uploaded logs", goes: "that no study and no payload holds", stay: "in a study or a payload" },
  job_logs: { head: "Log and steps of jobs", goes: "so long after a job ended; how and why it ended stays", stay: "of jobs that wait or run, or empty" },
  deliveries: { head: "What webhooks were told", goes: "so long after that ended", stay: "on its way" },
  audit: { head: "Audit", goes: "only by hand, into a file; a line of it tells that", stay: "" },
};

/** What of the lab goes because it is old, and how that is changed. */
export function WhatGoes() {
  const { data, error, refetch } = useRetention();
  if (error && !data) return <ProblemBox error={error} retry={() => void refetch()} />;
  if (!data) return <Loading what="what goes by age" />;
  const studies = data.kinds.find(({ what }) => what === "studies")!;
  return (
    <Stack gap="lg">
      <Text size="sm" c="dimmed" style={{ maxWidth: "60rem" }}>
        Robots, devices, payloads, motions, plans and what is published stay for good. What goes by age goes within an hour of its time, and the audit tells it, but
        for webhooks.
      </Text>
      <WideTable
        label="What goes by age"
        columns={["What", number("Kept", "days"), number("How many"), "Stay anyway", "The first goes", "Set by"]}
      >
        {data.kinds.map((item) => (
          <Row key={item.what} item={item} />
        ))}
      </WideTable>
      {data.studies.length > 0 && <Next studies={data.studies} of={studies.of} />}
      <Stack component="section" aria-labelledby="change" gap="xs" style={{ maxWidth: "60rem" }}>
        <Title order={2} size="h3" id="change">
          To change it
        </Title>
        <Text size="sm">
          Ages are settings of the service: ask who runs it. Studies have an age lab by lab; to keep this lab’s for a year, the setting is
        </Text>
        <Code block>{`EXOGAUGE_STUDIES_KEPT_DAYS='{"${data.lab_id}": 365}'`}</Code>
        <Text size="sm">
          To keep one study whatever its age, publish its results.
        </Text>
      </Stack>
    </Stack>
  );
}

function Row({ item }: { item: Item }) {
  const words = WORDS[item.what];
  return (
    <Table.Tr>
      <Table.Th scope="row">
        {words.head}
        <Text size="sm" c="dimmed" fw={400}>
          {words.goes}
        </Text>
      </Table.Th>
      <Table.Td data-number>{item.kept_days === null ? "for good" : String(item.kept_days)}</Table.Td>
      <Table.Td data-number>{item.of}</Table.Td>
      <Table.Td>
        {item.stay}
        {item.stay > 0 && (
          <Text size="sm" c="dimmed">
            {words.stay}
          </Text>
        )}
      </Table.Td>
      <Table.Td>{item.next_at ? <When at={item.next_at} /> : item.kept_days === null ? "never" : "none is there"}</Table.Td>
      <Table.Td>
        <code style={{ whiteSpace: "nowrap" }}>{item.setting}</code>
      </Table.Td>
    </Table.Tr>
  );
}

function Next({ studies, of }: { studies: Retention["studies"]; of: number }) {
  return (
    <Stack component="section" aria-labelledby="next" gap="sm">
      <Title order={2} size="h3" id="next">
        Studies that go next
      </Title>
      {of > studies.length && (
        <Text size="sm" c="dimmed">
          The first {studies.length} of {of}.
        </Text>
      )}
      <WideTable label="Studies that go next" columns={["Goes", "Study"]}>
        {studies.map((study) => (
          <Table.Tr key={study.id}>
            <Table.Td>
              <When at={study.goes_at} />
            </Table.Td>
            <Table.Td>
              <Link to={`/studies/${study.id}`}>{study.name}</Link>
            </Table.Td>
          </Table.Tr>
        ))}
      </WideTable>
    </Stack>
  );
}
