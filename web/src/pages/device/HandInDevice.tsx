import { Anchor, Code, NativeSelect, Stack, Text } from "@mantine/core";
import { useState } from "react";
import { Link, useNavigate } from "react-router";

import { useAddDevice } from "../../api/devices";
import { useRobots } from "../../api/robots";
import { DropFiles, type Dropped } from "../../parts/DropFiles";
import { ForMembers } from "../../parts/ForMembers";
import { ProblemBox } from "../../parts/ProblemBox";

export function HandInDevice() {
  return (
    <ForMembers told>
      <Zone />
    </ForMembers>
  );
}

function Zone() {
  const { data: robots = [] } = useRobots();
  const [chosen, choose] = useState("");
  const add = useAddDevice();
  const navigate = useNavigate();
  const robot = robots.find((each) => each.id === chosen) ?? robots[0];
  if (!robot) {
    return (
      <Text c="dimmed" size="sm">
        A device is checked on a robot: <Anchor component={Link} to="/robots" inherit underline="always">hand one in</Anchor> first,
        or take a device over from a study below, which brings its robot along.
      </Text>
    );
  }
  const take = (files: Dropped) => {
    const [only] = files.size === 1 ? [...files] : [];
    const named = only && /\.ya?ml$/i.test(only[0]) ? new Map([["device.yaml", only[1]]]) : files;
    add.mutate({ files: named, robot: robot.id }, { onSuccess: (device) => void navigate(`/devices/${device.id}`) });
  };
  return (
    <Stack gap="sm">
      <NativeSelect
        label="Robot that wears it"
        maw="24rem"
        value={robot.id}
        onChange={(event) => choose(event.currentTarget.value)}
        data={robots.map((each) => ({ value: each.id, label: `${each.name}, version ${each.version}` }))}
      />
      <DropFiles title="Hand in a device" choose="Choose files" take={take} busy={add.isPending}>
        Drop <Code>device.yaml</Code>, with the bench tests that it names. Every link and point is checked on the robot.
      </DropFiles>
      {add.error && <ProblemBox error={add.error} />}
    </Stack>
  );
}
