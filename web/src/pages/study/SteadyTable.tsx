import { Table, Text } from "@mantine/core";

import { significant } from "../../parts/digits";
import { number, WideTable } from "../../parts/WideTable";
import type { Num, SteadyShare } from "./results";

/** How long each joint moved steadily, of the time that it moved; results of before do not say. */
export function SteadyTable({ shares, words }: { shares: SteadyShare[]; words: string | undefined }) {
  if (!shares.length) return null;
  return (
    <details style={{ fontSize: "var(--mantine-font-size-sm)" }}>
      <summary>How long each joint moved steadily</summary>
      {words && (
        <Text size="sm" c="dimmed" my="xs">
          {words}
        </Text>
      )}
      <WideTable label="Seconds of steady motion" mostHeight="24rem" columns={["Joint", number("Fitted logs", "s"), number("Held-out logs", "s"), "Directions"]}>
        {shares.map((each) => (
          <Table.Tr key={each.joint}>
            <Table.Th scope="row">{each.joint}</Table.Th>
            <Table.Td data-number>{share(each.fitted_s, each.fitted_of_s)}</Table.Td>
            <Table.Td data-number>{share(each.held_out_s, each.held_out_of_s)}</Table.Td>
            <Table.Td>{each.both_directions ? "both" : "one only"}</Table.Td>
          </Table.Tr>
        ))}
      </WideTable>
    </details>
  );
}

function share(kept: Num, of: Num): string {
  return `${significant(kept)} of ${significant(of)}`;
}
