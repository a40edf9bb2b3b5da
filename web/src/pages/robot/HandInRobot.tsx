import { Code, Stack } from "@mantine/core";
import { useNavigate } from "react-router";

import { useAddRobot } from "../../api/robots";
import { DropFiles, type Dropped } from "../../parts/DropFiles";
import { ProblemBox } from "../../parts/ProblemBox";

export function HandInRobot() {
  const add = useAddRobot();
  const navigate = useNavigate();
  const take = (files: Dropped) => add.mutate(files, { onSuccess: (robot) => void navigate(`/robots/${robot.id}`) });
  return (
    <Stack gap="sm">
      <DropFiles title="Hand in a robot" choose="Choose files" take={take} busy={add.isPending}>
        Drop <Code>robot.yaml</Code> and the URDF that it names together, their folder, or one zip. Meshes are not needed.
        Other files under a name that is there already become its next version.
      </DropFiles>
      {add.error && <ProblemBox error={add.error} />}
    </Stack>
  );
}
