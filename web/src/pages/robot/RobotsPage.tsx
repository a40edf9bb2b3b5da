import { Anchor, Group, Stack, Text, Title } from "@mantine/core";
import { useEffect } from "react";
import { Link } from "react-router";

import { useRobots, type Robot } from "../../api/robots";
import { Empty } from "../../parts/Empty";
import { Loading } from "../../parts/Loading";
import { PageTitle } from "../../parts/PageTitle";
import { ProblemBox } from "../../parts/ProblemBox";
import { AtRight, Row, Rows } from "../../parts/Rows";
import { NothingFound, SearchBox } from "../../parts/SearchBox";
import { count } from "../../parts/size";
import { useSought, type Sought } from "../../parts/useSought";
import { When } from "../../parts/When";
import { fixed } from "../../parts/digits";
import { HandInRobot } from "./HandInRobot";
import { RobotsOfStudies } from "./RobotsOfStudies";

export function Component() {
  const sought = useSought();
  const { data: robots, error, refetch, hasNextPage, fetchNextPage, isFetchingNextPage } = useRobots(sought.words ? { search: sought.words } : {});
  useEffect(() => {
    if (hasNextPage && !error && !isFetchingNextPage) void fetchNextPage(); // versions of one robot stand together
  }, [hasNextPage, error, isFetchingNextPage, fetchNextPage]);
  return (
    <>
      <PageTitle title="Robots" lead="What wears a device: joints, drives, links and sensors as their maker says." />
      <HandInRobot />
      {error && !robots ? (
        <ProblemBox error={error} retry={() => void refetch()} />
      ) : !robots ? (
        <Loading what="the robots" />
      ) : (
        <Stack gap="xl" mt="xl">
          {robots.length > 0 || sought.words ? <RobotList robots={robots} sought={sought} /> : <NoRobots />}
          <RobotsOfStudies words={sought.words} />
        </Stack>
      )}
    </>
  );
}

function RobotList({ robots, sought }: { robots: Robot[]; sought: Sought }) {
  const names = [...new Set(robots.map((robot) => robot.name))];
  return (
    <section aria-labelledby="robots">
      <Group justify="space-between" align="flex-end" mb="sm">
        <Title order={2} size="h3" id="robots">
          Handed in
        </Title>
        <SearchBox what="robots" placeholder="Name of a robot" sought={sought} />
      </Group>
      {robots.length === 0 && (
        <NothingFound sentence={`No robot has “${sought.words}” in its name.`} clear={sought.clear} />
      )}
      <Rows>
        {names.map((name) => {
          const versions = robots.filter((robot) => robot.name === name);
          return <RobotRow key={name} robot={versions[0] as Robot} versions={versions.length} />;
        })}
      </Rows>
    </section>
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
  const words = (
    <>
      <Anchor component={Link} to={`/robots/${robot.id}`} fw={600}>
        {robot.name}
      </Anchor>
      <Text size="sm" c="dimmed">
        {facts.join(" · ")}
      </Text>
    </>
  );
  return (
    <Row words={words}>
      <AtRight>
        {versions > 1 ? `version ${robot.version} of ${versions}` : "one version"}
        <br />
        <When at={robot.created_at} />
      </AtRight>
    </Row>
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
