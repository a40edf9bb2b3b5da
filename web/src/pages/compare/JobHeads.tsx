import { Table } from "@mantine/core";

import type { Column } from "../../parts/WideTable";
import { approachShort, approachWords } from "./heads";
import styles from "./Matrix.module.css";

/** Over the columns of each job its name. before: columns that belong to no job. across: columns of each. */
export function JobHeads({ names, before, across }: { names: string[]; before: number; across: number }) {
  return (
    <Table.Tr>
      <Table.Td colSpan={before} />
      {names.map((name) => (
        <Table.Th key={name} scope="colgroup" colSpan={across} className={styles.job}>
          {name}
        </Table.Th>
      ))}
    </Table.Tr>
  );
}

/** A column for each approach of each job. */
export function jobColumns(names: string[], approaches: string[]): Column[] {
  const several = names.length > 1;
  return names.flatMap(() =>
    approaches.map((approach, k) => ({
      head: several ? approachShort(approach) : approachWords(approach),
      isNumber: true,
      ...(several && k === 0 && styles.job && { className: styles.job }),
    })),
  );
}
