import { Code, NativeSelect, Stack, Text } from "@mantine/core";

import { useStudies, type StateSought } from "../../api/studies";
import { Empty } from "../../parts/Empty";
import { count } from "../../parts/size";
import { ThingList } from "../../parts/ThingList";
import { useInAddress, useSought } from "../../parts/useSought";
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
  const query = useStudies(sought.words, state.value);
  const studies = query.data?.pages.flatMap((page) => page.items);
  const states = (
    <NativeSelect aria-label="State" data={STATES} value={state.value} onChange={(event) => setState(event.currentTarget.value)} />
  );
  return (
    <Stack mt="xl">
      <ThingList
        things="studies"
        pages={{ ...query, data: studies }}
        search={{
          sought,
          placeholder: "Name, robot or wear",
          nothing: nothing(sought.words, state),
          found: `${count(studies?.length ?? 0, "study", "studies")} found${query.hasNextPage ? ", and more" : ""}`,
          seeking: sought.words !== "" || state.value !== "",
          beside: states,
        }}
        none={<NoStudies />}
        row={(study) => <StudyRow key={study.id} study={study} />}
      />
    </Stack>
  );
}

function nothing(words: string, state: { value: string; label: string }): string {
  const which = state.value ? ` in the state “${state.label}”` : "";
  return words ? `No study${which} has “${words}” in its name, robot or wear.` : `No study is${which}.`;
}

function NoStudies() {
  return (
      <Empty title="No studies yet">
        <Text>
          Drop one above. To try with synthetic data, let <Code>exogauge sample my-sample --seed 7</Code> write a
          complete study, and drop the folder <Code>my-sample</Code>.
        </Text>
        <Text>
          <Code>make demo</Code> does both, and waits for the result.
        </Text>
      </Empty>
  );
}
