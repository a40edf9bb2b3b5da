import { Table, Text, Title } from "@mantine/core";

import type { Found } from "../../api/motions";
import { fixed, percent } from "../../parts/digits";
import { number, WideTable } from "../../parts/WideTable";

const degrees = (value: number | null | undefined, places = 1) => (typeof value === "number" ? fixed((180 / Math.PI) * value, places) : "–");
const range = ([low, high]: number[]) => `${degrees(low)} … ${degrees(high)}`;

/** What of the person's trunk was asked of each joint of the torso, and what it gives. */
export function Trunk({ found }: { found: Found }) {
  return (
    <section aria-labelledby="trunk">
      <Title order={2} size="h3" id="trunk" mb="xs">
        The trunk
      </Title>
      <WideTable
        label="Trunk"
        columns={[
          "Joint", number("asked", "°"), number("given", "°"), number("the joint bears", "°"), number("beyond it"), number("missed, rms", "°"),
          number("missed, most", "°"),
        ]}
      >
        {found.trunk.map((each) => (
          <Table.Tr key={each.joint}>
            <Table.Th scope="row">{each.joint}</Table.Th>
            <Table.Td data-number>{range(each.asked)}</Table.Td>
            <Table.Td data-number>{range(each.given)}</Table.Td>
            <Table.Td data-number>{range(each.bound)}</Table.Td>
            <Table.Td data-number>{each.beyond > 0 ? `${percent(each.beyond, 1)} of the time` : "never"}</Table.Td>
            <Table.Td data-number>{degrees(each.rms, 2)}</Table.Td>
            <Table.Td data-number>{degrees(each.most, 2)}</Table.Td>
          </Table.Tr>
        ))}
      </WideTable>
      {found.missed && found.missed.most > 1e-3 && (
        <Text size="sm" mt="xs">
          {degrees(found.missed.rms)}° rms and {degrees(found.missed.most)}° at most of the trunk’s turn lie in directions in which the torso has no joint.
        </Text>
      )}
    </section>
  );
}
