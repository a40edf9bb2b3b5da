import { Button, Code, Group, NativeSelect, Stack, Text, Title } from "@mantine/core";

import { useStudies, type StateSought } from "../../api/studies";
import { Empty } from "../../parts/Empty";
import { Loading } from "../../parts/Loading";
import { ProblemBox } from "../../parts/ProblemBox";
import { Rows } from "../../parts/Rows";
import { NothingFound, SearchBox } from "../../parts/SearchBox";
import { count } from "../../parts/size";
import { useInAddress, useSought } from "../../parts/useSought";
import styles from "./StudyList.module.css";
import { StudyRow } from "./StudyRow";

const STATES: { value: StateSought | ""; label: string }[] = [
  { value: "", label: "Any state" },
  { value: "none", label: "Not run yet" },
  { value: "queued", label: "Waiting" },
  { value: "running", label: "Running" },
  { value: "succeeded", label: "Done" },
  { value: "failed", label: "Failed" },
  { value: "cancelled", label: "Cancelled" },
];

export function StudyList() {
  const sought = useSought();
  const [said, setState] = useInAddress("state");
  const state = STATES.find(({ value }) => value === said) ?? { value: "" as const, label: "" };
  const { data, error, refetch, hasNextPage, fetchNextPage, isFetchingNextPage } = useStudies(sought.words, state.value);
  const seeking = sought.words !== "" || state.value !== "";

  if (error && !data) return <ProblemBox error={error} retry={() => void refetch()} />;
  if (!data) return <Loading what="the studies" />;
  const studies = data.pages.flatMap((page) => page.items);
  if (studies.length === 0 && !seeking) return <NoStudies />;
  return (
    <Stack component="section" gap="sm" mt="xl" aria-labelledby="studies">
      <Group justify="space-between" align="flex-end">
        <Title order={2} size="h3" id="studies">
          Handed in
        </Title>
        <Group gap="sm" className={styles.search} wrap="nowrap">
          <SearchBox what="studies" placeholder="Name, robot or wear" sought={sought} />
          <NativeSelect
            aria-label="State"
            data={STATES}
            value={state.value}
            onChange={(event) => setState(event.currentTarget.value)}
          />
        </Group>
      </Group>
      {studies.length > 0 ? (
        <Text size="sm" c="dimmed" role="status">
          {seeking ? `${count(studies.length, "study", "studies")} found${hasNextPage ? ", and more" : ""}` : ""}
        </Text>
      ) : (
        <NothingFound sentence={nothing(sought.words, state)} clear={sought.clear} />
      )}
      <Rows>
        {studies.map((study) => (
          <StudyRow key={study.id} study={study} />
        ))}
      </Rows>
      {hasNextPage && (
        <Button variant="default" onClick={() => void fetchNextPage()} loading={isFetchingNextPage} mx="auto">
          Show older studies
        </Button>
      )}
    </Stack>
  );
}

function nothing(words: string, state: { value: string; label: string }): string {
  const which = state.value ? ` in the state “${state.label}”` : "";
  return words ? `No study${which} has “${words}” in its name, robot or wear.` : `No study is${which}.`;
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
