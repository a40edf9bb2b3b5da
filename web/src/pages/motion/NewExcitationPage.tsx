import { Button, Group, Select, Stack, Text } from "@mantine/core";
import { useState } from "react";
import { useNavigate } from "react-router";

import { useCreatePlan } from "../../api/motions";
import { useRobots } from "../../api/robots";
import { useEveryStudy } from "../../api/studies";
import { NumberField } from "../../parts/NumberField";
import { PageTitle } from "../../parts/PageTitle";
import { ProblemBox } from "../../parts/ProblemBox";
import { RobotChoice } from "./AskRobot";

/** Ask for a motion from which a robot is identified well. */
export function Component() {
  const { data: robots } = useRobots();
  const [robotId, choose] = useState<string | null>(null);
  const [studyId, setStudy] = useState<string | null>(null);
  const [seconds, setSeconds] = useState<number | undefined>(10);
  const { studies } = useEveryStudy(robotId ? { robot_id: robotId } : {});
  const create = useCreatePlan();
  const navigate = useNavigate();
  const ask = () =>
    create.mutate(
      { robot_id: robotId!, ...(studyId ? { study_id: studyId } : {}), excite: { seconds: seconds ?? 10, seed: 0 } },
      { onSuccess: (plan) => void navigate(`/plans/${plan.id}`) },
    );
  return (
    <>
      <PageTitle title="A motion that identifies" lead="Within every bound; it says how well each parameter will be known." />
      <Stack gap="md" maw={640}>
        <RobotChoice robots={robots ?? []} value={robotId} choose={choose} />
        <Select
          label="A study whose logs are known already"
          placeholder="none"
          clearable
          searchable
          disabled={!robotId}
          data={(studies ?? []).map((study) => ({ value: study.id, label: study.name }))}
          value={studyId}
          onChange={setStudy}
        />
        <NumberField label="Seconds of the motion itself" value={seconds} set={setSeconds} />
        <Group>
          <Button disabled={!robotId} loading={create.isPending} onClick={ask}>
            Plan it
          </Button>
        </Group>
        <Text size="sm" c="dimmed">
          An arm takes seconds, a robot on two feet about a minute of computing.
        </Text>
        {create.error && <ProblemBox error={create.error} />}
      </Stack>
    </>
  );
}
