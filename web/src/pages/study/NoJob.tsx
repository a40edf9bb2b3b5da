import { Button, Text } from "@mantine/core";

import { useSubmitJob, type Study } from "../../api/studies";
import { Empty } from "../../parts/Empty";
import { ProblemBox } from "../../parts/ProblemBox";
import { useQueryClient } from "@tanstack/react-query";
import { RunSection } from "./RunSection";

/** A study of which nothing was made yet. */
export function NoJob({ study }: { study: Study }) {
  const cache = useQueryClient();
  const submit = useSubmitJob();
  const start = () =>
    submit.mutate(
      { study_id: study.id, kind: "evaluate" },
      { onSuccess: () => cache.invalidateQueries({ queryKey: ["jobs", study.id] }) },
    );
  return (
    <>
      <Empty title="Not evaluated yet">
        <Text>The files were read and are in order. The evaluation makes every step that they allow.</Text>
        <Button loading={submit.isPending} onClick={start}>
          Evaluate
        </Button>
        {submit.error && <ProblemBox error={submit.error} />}
      </Empty>
      <div style={{ marginTop: "var(--mantine-spacing-xl)" }}>
        <RunSection study={study} job={null} />
      </div>
    </>
  );
}
