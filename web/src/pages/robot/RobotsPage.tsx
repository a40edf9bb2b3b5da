import { Anchor, Paper, Stack, Text, Title } from "@mantine/core";
import { useEffect } from "react";
import { Link } from "react-router";

import { useRobots, type Robot } from "../../api/robots";
import { Empty } from "../../parts/Empty";
import { Loading } from "../../parts/Loading";
import { PageTitle } from "../../parts/PageTitle";
import { ProblemBox } from "../../parts/ProblemBox";
import { count } from "../../parts/size";
import { When } from "../../parts/When";
import { fixed } from "../../parts/number";
import { HandInRobot } from "./HandInRobot";
import styles from "./RobotList.module.css";
import { RobotsOfStudies } from "./RobotsOfStudies";

export function Component() {
  const { data: robots, error, refetch, hasNextPage, fetchNextPage, isFetchingNextPage } = useRobots();
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
          {robots.length > 0 ? <RobotList robots={robots} /> : <NoRobots />}
          <RobotsOfStudies robots={robots} />
        </Stack>
      )}
    </>
  );
}

function RobotList({ robots }: { robots: Robot[] }) {
  const names = [...new Set(robots.map((robot) => robot.name))];
  return (
    <section aria-labelledby="robots">
      <Title order={2} size="h3" id="robots" mb="sm">
        Handed in
      </Title>
      <ul className={styles.list}>
        {names.map((name) => {
          const versions = robots.filter((robot) => robot.name === name);
          return <RobotRow key={name} robot={versions[0] as Robot} versions={versions.length} />;
        })}
      </ul>
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
  return (
    <Paper withBorder component="li" className={styles.row}>
      <div>
        <Anchor component={Link} to={`/robots/${robot.id}`} fw={600}>
          {robot.name}
        </Anchor>
        <Text size="sm" c="dimmed">
          {facts.join(" · ")}
        </Text>
      </div>
      <Text size="sm" c="dimmed" className={styles.right}>
        {versions > 1 ? `version ${robot.version} of ${versions}` : "one version"}
        <br />
        <When at={robot.created_at} />
      </Text>
    </Paper>
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
