import { Table } from "@mantine/core";

import { percent, significant } from "../../parts/digits";
import { number, WideTable } from "../../parts/WideTable";
import type { DoubtPart, DoubtSource, Num } from "./results";

export type Doubted = { name: string; unit: string; parts: DoubtPart[] };

/** What the doubts of a few numbers are made of: each source alone, the largest first, and what would make it smaller. */
export function DoubtTable({ summary, numbers, sources }: { summary: string; numbers: Doubted[]; sources: DoubtSource[] }) {
  const told = numbers.filter(({ parts }) => parts.length);
  const share = ({ source }: DoubtSource) => Math.max(...told.map(({ parts }) => square(parts, source) / (square(parts) || 1)));
  const shown = sources.filter(({ source }) => told.some(({ parts }) => parts.some((part) => part.source === source)));
  if (!told.length) return null;
  return (
    <details>
      <summary>{summary}</summary>
      <WideTable label={summary} columns={["Source", ...told.map(({ name, unit }) => number(name, unit)), "What would make it smaller"]}>
        {[...shown]
          .sort((one, other) => share(other) - share(one))
          .map(({ source, words, advice }) => (
            <Table.Tr key={source} data-source={source}>
              <Table.Th scope="row">{words}</Table.Th>
              {told.map(({ name, parts }) => (
                <Table.Td key={name} data-number title={`${percent(square(parts, source) / (square(parts) || 1))} of the variance`}>
                  {significant(Math.sqrt(square(parts, source)), 2)}
                </Table.Td>
              ))}
              <Table.Td>{advice}</Table.Td>
            </Table.Tr>
          ))}
      </WideTable>
    </details>
  );
}

/** The source that makes most of a doubt, and its share of the variance. */
export function largest(parts: DoubtPart[] | null | undefined): { source: string; share: number } | null {
  const [first] = parts ?? [];
  return first ? { source: first.source, share: square([first]) / (square(parts!) || 1) } : null;
}

function square(parts: { source: string; std: Num }[], source?: string): number {
  return parts.filter((part) => source === undefined || part.source === source).reduce((sum, { std }) => sum + (std ?? 0) ** 2, 0);
}
