import { Button, Text } from "@mantine/core";

import { useSubmitJob, type Study } from "../../api/studies";
import { Empty } from "../../parts/Empty";
import { ForMembers } from "../../parts/ForMembers";
import { ProblemBox } from "../../parts/ProblemBox";
import { useDeed } from "../../parts/useDeed";
import { useQueryClient } from "@tanstack/react-query";
import { RunSection } from "./RunSection";

/** A study of which nothing was made yet. */
export function NoJob({ study }: { study: Study }) {
  const cache = useQueryClient();
  const submit = useSubmitJob();
  const { start, busy, error } = useDeed();
  const evaluate = async () => {
    await submit.mutateAsync({ study_id: study.id, kind: "evaluate" });
    await cache.invalidateQueries({ queryKey: ["jobs", study.id] });
  };
  return (
    <>
      <Empty title="Not evaluated yet">
        <Text>The files were read and are in order. The evaluation makes every step that they allow.</Text>
        <ForMembers told>
          <Button loading={busy} onClick={() => start(evaluate)}>
            Evaluate
          </Button>
        </ForMembers>
        {error !== null && <ProblemBox error={error} />}
      </Empty>
      <div style={{ marginTop: "var(--mantine-spacing-xl)" }}>
        <RunSection study={study} job={null} />
      </div>
    </>
  );
}
