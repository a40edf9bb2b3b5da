import { Table } from "@mantine/core";

import { percent } from "../../parts/digits";
import { number, WideTable } from "../../parts/WideTable";
import type { Candidate } from "./results";
import { titleOf } from "./words";

/** Candidates with the share of the excess that each explains on held-out logs, and why it was not chosen. */
export function CandidateTable({ name, rows, chosen }: { name: string; rows: Candidate[]; chosen?: number }) {
  const best = new Map<string, [Candidate, boolean]>();
  rows.forEach((each, k) => {
    const key = titleOf(each);
    const known = best.get(key);
    if (!known || (each.score ?? -1) > (known[0].score ?? -1)) best.set(key, [each, k === chosen]);
  });
  const shown = [...best.entries()].sort(([, [one]], [, [two]]) => (two.score ?? -1) - (one.score ?? -1));
  return (
    <WideTable label={name} columns={["Effect", number("Explains"), "Why"]}>
      {shown.map(([title, [each, named]]) => (
        <Table.Tr key={title}>
          <Table.Th scope="row" style={named ? { fontWeight: 700 } : undefined}>
            {title}
          </Table.Th>
          <Table.Td data-number>{each.score === null ? "–" : percent(Math.max(each.score, 0))}</Table.Td>
          <Table.Td>{each.reason}</Table.Td>
        </Table.Tr>
      ))}
    </WideTable>
  );
}
