import { Switch, Table, Text, Title } from "@mantine/core";
import { useState } from "react";

import type { Found } from "../../api/motions";
import { percent, significant, unitOf } from "../../parts/digits";
import { number, WideTable } from "../../parts/WideTable";

/** How well each parameter will be known once the motion was recorded. */
export function Certainties({ found }: { found: Found }) {
  const [all, showAll] = useState(false);
  const counts = found.counts ?? []; // plans of earlier versions have none
  const open = found.parameters.filter(({ before }) => before > 0);
  const shown = all ? open : open.filter(({ kind }) => kind !== "link");
  return (
    <section aria-labelledby="certain">
      <Title order={2} size="h3" id="certain" mb="xs">
        How well each parameter will be known
      </Title>
      {counts.length > 0 && (
        <Text size="sm" mb="xs">
          {counts.map(countWords).join(" and ")} will be decided by the data.
        </Text>
      )}
      <Switch size="sm" mb="xs" label="Links one by one, too" checked={all} onChange={(event) => showAll(event.currentTarget.checked)} />
      <WideTable
        label="Predicted standard deviations"
        columns={["Parameter", "Unit", number("std before"), number("std then"), number("left of it"), "Remark"]}
        mostHeight="24rem"
      >
        {shown.map((each) => (
          <Table.Tr key={each.name}>
            <Table.Th scope="row">{each.name}</Table.Th>
            <Table.Td>{unitOf(each.unit)}</Table.Td>
            <Table.Td data-number>{significant(each.before, 2)}</Table.Td>
            <Table.Td data-number>{significant(each.std, 2)}</Table.Td>
            <Table.Td data-number>{percent(each.std / each.before, 1)}</Table.Td>
            <Table.Td>{each.decided ? "" : "not decided"}</Table.Td>
          </Table.Tr>
        ))}
      </WideTable>
    </section>
  );
}

function countWords({ kind, decided, of, left }: NonNullable<Found["counts"]>[number]) {
  return `${decided} of ${of} ${kind} parameters (median ${percent(left, 1)} of the doubt before is left)`;
}
