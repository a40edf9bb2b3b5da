import { Button, Code, Group, NativeSelect, Stack, Text, TextInput, Title } from "@mantine/core";
import { IconSearch } from "@tabler/icons-react";
import { useEffect, useState } from "react";

import { useStudies, type Study } from "../../api/studies";
import { Empty } from "../../parts/Empty";
import { Loading } from "../../parts/Loading";
import { ProblemBox } from "../../parts/ProblemBox";
import { count } from "../../parts/size";
import { factsOf } from "./facts";
import styles from "./StudyList.module.css";
import { StudyRow } from "./StudyRow";

const STATES = [
  { value: "", label: "Any state" },
  { value: "none", label: "Not run yet" },
  { value: "queued", label: "Waiting" },
  { value: "running", label: "Running" },
  { value: "succeeded", label: "Done" },
  { value: "failed", label: "Failed" },
  { value: "cancelled", label: "Cancelled" },
];

export function StudyList() {
  const { data, error, refetch, hasNextPage, fetchNextPage, isFetchingNextPage } = useStudies();
  const [words, setWords] = useState("");
  const [state, setState] = useState("");
  const seeking = words.trim() !== "" || state !== "";

  useEffect(() => {
    if (seeking && hasNextPage && !isFetchingNextPage && !error) void fetchNextPage(); // what is sought may be older
  }, [seeking, hasNextPage, isFetchingNextPage, error, fetchNextPage, data]);

  if (error && !data) return <ProblemBox error={error} retry={() => void refetch()} />;
  if (!data) return <Loading what="the studies" />;
  const all = data.pages.flatMap((page) => page.items);
  if (all.length === 0) return <NoStudies />;
  const shown = all.filter((study) => holds(study, words) && isIn(study, state));
  return (
    <Stack component="section" gap="sm" mt="xl" aria-labelledby="studies">
      <Group justify="space-between" align="flex-end">
        <Title order={2} size="h3" id="studies">
          Handed in
        </Title>
        <Group gap="sm" className={styles.search} wrap="nowrap">
          <TextInput
            aria-label="Search studies"
            placeholder="Name, robot or wear"
            type="search"
            className={styles.sought}
            leftSection={<IconSearch size={16} aria-hidden />}
            value={words}
            onChange={(event) => setWords(event.currentTarget.value)}
          />
          <NativeSelect
            aria-label="State"
            data={STATES}
            value={state}
            onChange={(event) => setState(event.currentTarget.value)}
          />
        </Group>
      </Group>
      <Text size="sm" c="dimmed" role="status">
        {seeking
          ? `${shown.length} of ${count(all.length, "study", "studies")}${hasNextPage ? ", looking further …" : ""}`
          : ""}
      </Text>
      <ul className={styles.list}>
        {shown.map((study) => (
          <StudyRow key={study.id} study={study} />
        ))}
      </ul>
      {hasNextPage && !seeking && (
        <Button variant="default" onClick={() => void fetchNextPage()} loading={isFetchingNextPage} mx="auto">
          Show older studies
        </Button>
      )}
    </Stack>
  );
}

function NoStudies() {
  return (
    <Stack mt="xl">
      <Empty title="No studies yet">
        <Text>
          Drop one above. To try with synthetic data, let <Code>exogauge sample my-sample --seed 7</Code> write a
          complete study, and drop the folder <Code>my-sample</Code>.
        </Text>
        <Text>
          <Code>make demo</Code> does both, and waits for the result.
        </Text>
      </Empty>
    </Stack>
  );
}

function holds(study: Study, words: string): boolean {
  const text = [study.name, study.content_hash, ...factsOf(study)].join(" ").toLowerCase();
  return words
    .toLowerCase()
    .split(/\s+/)
    .every((word) => text.includes(word));
}

function isIn(study: Study, state: string): boolean {
  return state === "" || (study.latest_job?.state ?? "none") === state;
}
