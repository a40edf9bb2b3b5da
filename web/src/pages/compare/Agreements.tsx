import { Stack, Table, Text, Title } from "@mantine/core";

import type { ComparedDevice, Quantity } from "../../api/betweenLabs";
import { figure, NONE, percent, significant } from "../../parts/digits";
import { Uncertain } from "../../parts/Uncertain";
import { number, WideTable } from "../../parts/WideTable";
import { Forest } from "./Forest";

const QUANTITIES: Record<Quantity["quantity"], string> = {
  stiffness: "Stiffness",
  natural_length: "Natural length",
  peak_torque: "Peak torque",
  mean_torque: "Mean torque",
};
const VERDICTS = { agree: "agree within their doubts", differ: "differ", undecided: "undecided: one lab" };

/** Whether labs agree, quantity by quantity; of each lab the newest study that decides it. */
export function Agreements({ device }: { device: ComparedDevice }) {
  const { quantities } = device;
  const stiffness = quantities.filter((each) => each.quantity === "stiffness");
  if (quantities.length === 0) return <Text>No study decides a number of it.</Text>;
  return (
    <Stack component="section" gap="sm" aria-labelledby="agreement">
      <Title order={2} size="h3" id="agreement">
        Do the labs agree?
      </Title>
      {stiffness.map((each) => (
        <Forest key={each.of} title={`Stiffness of ${each.of} [${each.unit}]`} quantity={each} studies={device.studies} />
      ))}
      <WideTable
        label="Do the labs agree?"
        columns={["Quantity", number("Labs"), "They", number("Mean ± std"), number("Between labs"), number("95 %"), number("Q"), number("by chance"), number("I²"), number("Birge ratio")]}
      >
        {quantities.map(({ quantity, of, unit, found }) => (
          <Table.Tr key={`${quantity} ${of}`} data-quantity={`${quantity} ${of}`}>
            <Table.Th scope="row">
              {QUANTITIES[quantity]}, {of}
            </Table.Th>
            <Table.Td data-number>{found.labs}</Table.Td>
            <Table.Td>
              {VERDICTS[found.verdict]}
              {found.verdict !== "undecided" && found.provisional && ", provisional"}
            </Table.Td>
            <Table.Td data-number>{found.mean === null ? NONE : <Uncertain value={found.mean} std={found.std} unit={unit} />}</Table.Td>
            <Table.Td data-number>{found.tau === null ? NONE : `${significant(found.tau, 2)} ${unit}`}</Table.Td>
            <Table.Td data-number>
              {found.tau_interval === null ? NONE : `${figure(found.tau_interval[0], 2)} … ${figure(found.tau_interval[1], 2)}`}
            </Table.Td>
            <Table.Td data-number>{significant(found.q, 2)}</Table.Td>
            <Table.Td data-number>{significant(found.probability, 2)}</Table.Td>
            <Table.Td data-number>{percent(found.i_squared)}</Table.Td>
            <Table.Td data-number>{significant(found.birge_ratio, 2)}</Table.Td>
          </Table.Tr>
        ))}
      </WideTable>
      <Text size="sm" c="dimmed" style={{ maxWidth: "70rem" }}>
        Of each lab the newest study that decides the quantity. Q sums squared differences from the weighted mean over their variances; labs differ where chance alone
        reaches it in fewer than 5 of 100 cases. Between labs: the standard deviation beyond what they state; its interval tells how much could be hidden, and there is none where they agree better than chance has it. Below eight labs
        all of it is provisional (ISO 5725-2). Torques are compared on robots and in motions of one name.
      </Text>
    </Stack>
  );
}
