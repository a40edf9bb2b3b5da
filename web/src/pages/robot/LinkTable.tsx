import { Switch, Group, Table, Title, Text } from "@mantine/core";
import { useState } from "react";

import type { RobotModel } from "../../api/robots";
import { figure, fixed, NONE } from "../../parts/digits";
import { number, WideTable } from "../../parts/WideTable";
import styles from "./LinkTable.module.css";

type Props = { model: RobotModel; marked: string | null; mark: (link: string | null) => void };

/** Where links and frames are: what one needs to write down a via point. */
export function LinkTable({ model, marked, mark }: Props) {
  const [frames, setFrames] = useState(false);
  const shown = frames ? model.links : model.links.filter((link) => link.name === link.body);
  return (
    <section onMouseLeave={() => mark(null)} aria-labelledby="links">
      <Group justify="space-between" align="flex-end" mb="sm">
        <Title order={2} size="h3" id="links">
          Links
        </Title>
        <Switch
          label={`Also the ${model.links.length - model.links.filter((link) => link.name === link.body).length} frames fixed to them`}
          checked={frames}
          onChange={(event) => setFrames(event.currentTarget.checked)}
        />
      </Group>
      <WideTable
        label="Links"
        mostHeight="32rem"
        columns={[
          "Link",
          "Moved by",
          ...["x", "y", "z"].map((axis) => number(axis, "m")),
          "Its x, y, z axes point",
          number("Mass", "kg"),
          number("Centre of mass", "m, own frame"),
        ]}
      >
        {shown.map((link) => (
          <Table.Tr key={link.name} onMouseEnter={() => mark(link.name)} className={link.name === marked ? styles.marked : undefined}>
            <Table.Th scope="row">{link.name}</Table.Th>
            <Table.Td>{link.joint ?? (link.name === model.base_link ? "the base" : `fixed to ${link.body}`)}</Table.Td>
            {[0, 1, 2].map((k) => (
              <Table.Td key={k} data-number>
                {fixed(link.at[k], 3)}
              </Table.Td>
            ))}
            <Table.Td>{[0, 1, 2].map((k) => way([0, 1, 2].map((row) => link.turn[3 * row + k] ?? 0))).join(", ")}</Table.Td>
            <Table.Td data-number>{figure(link.mass_kg, 3)}</Table.Td>
            <Table.Td data-number>{link.centre ? link.centre.map((each) => fixed(each, 3)).join(", ") : NONE}</Table.Td>
          </Table.Tr>
        ))}
      </WideTable>
      <Text size="sm" c="dimmed" mt="xs">
        With all joints at zero, seen from {model.base_link}: x forward, y to the left, z up.
      </Text>
    </section>
  );
}

const WAYS = [
  ["forward", "back"],
  ["left", "right"],
  ["up", "down"],
] as const;

/** `forward`; `forward-down` where it lies between the two. */
function way(direction: number[]): string {
  const order = [0, 1, 2].sort((a, b) => Math.abs(direction[b] ?? 0) - Math.abs(direction[a] ?? 0));
  const words = order.map((axis) => WAYS[axis]?.[(direction[axis] ?? 0) > 0 ? 0 : 1]);
  return Math.abs(direction[order[0] ?? 0] ?? 0) > 0.985 ? `${words[0]}` : `${words[0]}-${words[1]}`;
}
