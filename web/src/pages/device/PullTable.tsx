import { Table, Text, Title } from "@mantine/core";

import type { Device } from "../../api/devices";
import { fixed } from "../../parts/digits";
import { number, WideTable } from "../../parts/WideTable";

/** Which way the saved band pulls, as the service's check says in words. */
export function PullTable({ device, band }: { device: Device; band: string }) {
  const found = device.summary.bands.find((each) => each.name === band);
  if (!found) return null;
  return (
    <div>
      <Title order={3} size="h5" mb={4}>
        Which way {band} pulls
      </Title>
      <WideTable label={`Which way ${band} pulls`} columns={["Joint", number("Moment arm", "mm"), "Pulls"]}>
        {found.arms_at_zero.map((arm) => (
          <Table.Tr key={arm.joint}>
            <Table.Th scope="row">{arm.joint}</Table.Th>
            <Table.Td data-number>{fixed(1000 * arm.arm_m, 1)}</Table.Td>
            <Table.Td>{arm.pulls}</Table.Td>
          </Table.Tr>
        ))}
      </WideTable>
      <Text size="sm" c="dimmed" mt={4}>
        As saved, with all joints at zero.
      </Text>
    </div>
  );
}
