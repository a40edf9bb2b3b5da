import { Stack, Text } from "@mantine/core";

import { useRobots, type Robot } from "../../api/robots";
import { fixed } from "../../parts/digits";
import { Empty } from "../../parts/Empty";
import { PageTitle } from "../../parts/PageTitle";
import { count } from "../../parts/size";
import { Standing, ThingList, ThingRow, useNewestOfEach } from "../../parts/ThingList";
import { useSought } from "../../parts/useSought";
import { HandInRobot } from "./HandInRobot";
import { RobotsOfStudies } from "./RobotsOfStudies";

export function Component() {
  const sought = useSought();
  const robots = useNewestOfEach(useRobots(sought.words ? { search: sought.words } : {}));
  return (
    <>
      <PageTitle title="Robots" lead="What wears a device: joints, drives, links and sensors as their maker says." />
      <HandInRobot />
      <Stack gap="xl" mt="xl">
        <ThingList
          things="robots"
          pages={robots}
          search={{ sought, placeholder: "Name of a robot", nothing: `No robot has “${sought.words}” in its name.` }}
          none={<NoRobots />}
          row={(robot) => <RobotRow key={robot.id} robot={robot} versions={robot.versions} />}
        />
        {robots.data && <RobotsOfStudies words={sought.words} />}
      </Stack>
    </>
  );
}

function RobotRow({ robot, versions }: { robot: Robot; versions: number }) {
  const { joints, sensors, base, mass_kg } = robot.summary;
  const facts = [
    count(joints.length, "joint"),
    base === "floating" ? "walks or stands free" : "fixed to the ground",
    `${fixed(mass_kg, 1)} kg`,
    count(sensors.length, "force/torque sensor"),
  ];
  return (
    <ThingRow to={`/robots/${robot.id}`} name={robot.name} facts={facts.join(" · ")}>
      <Standing at={robot.created_at} version={robot.version} of={versions} />
    </ThingRow>
  );
}

function NoRobots() {
  return (
    <Empty title="No robots yet">
      <Text>
        A robot is needed on its own for two things: to map the columns of a controller’s log to its joints, and to check a
        device on it. A study handed in as a whole brings its own.
      </Text>
    </Empty>
  );
}
