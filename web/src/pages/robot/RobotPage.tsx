import { Anchor, Group, SimpleGrid, Stack, Text, Title } from "@mantine/core";
import { lazy, useState } from "react";
import { Link, useParams } from "react-router";

import { useDevices } from "../../api/devices";
import { fileAddress, useRobot, useRobots, type Robot } from "../../api/robots";
import { ForMembers } from "../../parts/ForMembers";
import { DeleteButton } from "../../parts/DeleteButton";
import { DrawnOr3D } from "../../parts/DrawnOr3D";
import { Empty } from "../../parts/Empty";
import { FactList } from "../../parts/FactList";
import { FileTable } from "../../parts/FileTable";
import { LinkButton } from "../../parts/LinkButton";
import { Loading } from "../../parts/Loading";
import { figure, fixed } from "../../parts/digits";
import { PageTitle } from "../../parts/PageTitle";
import { ProblemBox } from "../../parts/ProblemBox";
import { StickFigure } from "../../parts/StickFigure";
import { When } from "../../parts/When";
import { Drives } from "./Drives";
import { JointTable } from "./JointTable";
import { LinkTable } from "./LinkTable";
import { SensorTable } from "./SensorTable";

const RestingRobot = lazy(() => import("../../view3d/RestingRobot").then((module) => ({ default: module.RestingRobot })));

export function Component() {
  const { robotId = "" } = useParams();
  const { data: robot, error, refetch } = useRobot(robotId);
  const [marked, mark] = useState<string | null>(null);
  if (error && !robot) return <ProblemBox error={error} retry={() => void refetch()} />;
  if (!robot) return <Loading what="the robot" lines={6} />;
  const { model } = robot.summary;
  return (
    <>
      <PageTitle title={robot.name} lead={`Version ${robot.version}, as its maker describes it`}>
        <ForMembers>
        <LinkButton to={`/import?robot=${robot.id}`} variant="default">
          Import a log of it
        </LinkButton>
        </ForMembers>
        <DeleteButton kind="robots" id={robot.id} name={robot.name}>
          Its files go. Studies keep their own; devices that it wears have to be deleted before.
        </DeleteButton>
      </PageTitle>
      <Stack gap="xl">
        <SimpleGrid cols={{ base: 1, md: 2 }} spacing="xl">
          <Overview robot={robot} />
          {model && (
            <DrawnOr3D
              drawing={
                <StickFigure model={model} label={`${robot.name} as a stick figure, all joints at zero`} named={marked ? [marked] : []} />
              }
              solid={() => <RestingRobot robotId={robot.id} name={robot.name} />}
            />
          )}
        </SimpleGrid>
        {model ? (
          <>
            <JointTable joints={model.joints} locked={model.locked} mark={mark} />
            <Drives robot={robot} joints={model.joints} />
            <LinkTable model={model} marked={marked} mark={mark} />
            <SensorTable model={model} />
          </>
        ) : (
          <Empty title="Its joints and links are not at hand">
            <Text>This robot was stored by an earlier version of the service. Its files are below.</Text>
          </Empty>
        )}
        <section aria-labelledby="files">
          <Title order={2} size="h3" id="files" mb="sm">
            Files
          </Title>
          <FileTable label="Files of the robot" files={robot.files ?? []} href={(path) => fileAddress("robots", robot.id, path)} />
        </section>
      </Stack>
    </>
  );
}

function Overview({ robot }: { robot: Robot }) {
  const { summary } = robot;
  const { data: devices = [] } = useDevices({ robot_id: robot.id });
  const { data: robots = [] } = useRobots();
  const others = robots.filter((each) => each.name === robot.name && each.id !== robot.id);
  const model = summary.model;
  return (
    <Stack gap="sm">
      <Title order={2} size="h3">
        Overview
      </Title>
      <FactList
        facts={[
          ["Base", summary.base === "floating" ? `floating, ${model?.base_link ?? ""}` : `fixed, ${model?.base_link ?? ""}`],
          ["Joints", summary.joints.length],
          ["Mass of what moves", `${figure(summary.mass_kg, 4)} kg`],
          ...(model
            ? [["Uncertainty of each link’s inertia", inertia(model.inertial_std)] as [string, string]]
            : []),
          ["Handed in", <When key="when" at={robot.created_at} />],
          [
            "Other versions",
            others.length === 0 ? (
              "none"
            ) : (
              <Group gap="xs">
                {others.map((each) => (
                  <Anchor key={each.id} component={Link} to={`/robots/${each.id}`}>
                    version {each.version}
                  </Anchor>
                ))}
              </Group>
            ),
          ],
          [
            "Devices checked on it",
            devices.length === 0 ? (
              "none"
            ) : (
              <Group gap="xs">
                {devices.map((each) => (
                  <Anchor key={each.id} component={Link} to={`/devices/${each.id}`}>
                    {each.name}, version {each.version}
                  </Anchor>
                ))}
              </Group>
            ),
          ],
        ]}
      />
    </Stack>
  );
}

function inertia(std: Record<string, number>): string {
  const words = Object.entries(std).map(([link, share]) =>
    link === "default" ? `± ${fixed(100 * share, 0)} %` : `${link} ± ${fixed(100 * share, 0)} %`,
  );
  return words.join(", ") || "not said";
}
