import { Table, Text, Title } from "@mantine/core";

import type { RobotJoint } from "../../api/robots";
import { figure } from "../../parts/digits";
import { number, WideTable } from "../../parts/WideTable";

const LOGGED = { current: "motor current", torque: "torque", none: "position only" };

type Props = { joints: RobotJoint[]; locked: string[]; mark: (link: string | null) => void };

export function JointTable({ joints, locked, mark }: Props) {
  const slides = joints.some((joint) => joint.kind === "prismatic");
  return (
    <section onMouseLeave={() => mark(null)} aria-labelledby="joints">
      <Title order={2} size="h3" id="joints" mb="sm">
        Joints
      </Title>
      <WideTable
        label="Joints"
        mostHeight="32rem"
        columns={[
          "Joint",
          "Moves",
          ...(slides ? ["Kind"] : []),
          "What is logged",
          number("Gear ratio"),
          number("Lowest", slides ? "° or m" : "°"),
          number("Highest", slides ? "° or m" : "°"),
          number("Speed", slides ? "rad/s, m/s" : "rad/s"),
          number("Effort", slides ? "N·m, N" : "N·m"),
        ]}
      >
        {joints.map((joint) => {
          const angle = (value: number | null) =>
            figure(value !== null && joint.kind === "revolute" ? (value * 180) / Math.PI : value, 4);
          return (
            <Table.Tr key={joint.name} onMouseEnter={() => mark(joint.moves)}>
              <Table.Th scope="row">{joint.name}</Table.Th>
              <Table.Td>{joint.moves}</Table.Td>
              {slides && <Table.Td>{joint.kind === "revolute" ? "turns" : "slides"}</Table.Td>}
              <Table.Td>{LOGGED[joint.actuation]}</Table.Td>
              <Table.Td data-number>{figure(joint.gear_ratio)}</Table.Td>
              <Table.Td data-number>{angle(joint.lower)}</Table.Td>
              <Table.Td data-number>{angle(joint.upper)}</Table.Td>
              <Table.Td data-number>{figure(joint.velocity)}</Table.Td>
              <Table.Td data-number>{figure(joint.effort)}</Table.Td>
            </Table.Tr>
          );
        })}
      </WideTable>
      {locked.length > 0 && (
        <Text size="sm" c="dimmed" mt="xs">
          Held at zero, because robot.yaml does not list them: {locked.join(", ")}.
        </Text>
      )}
    </section>
  );
}
