import { Table, VisuallyHidden } from "@mantine/core";
import type { ReactNode } from "react";

import styles from "./WideTable.module.css";

/** A column's head; text stands to the left, numbers to the right. */
export type Column = string | { head: ReactNode; unit?: string; isNumber?: boolean; className?: string };

/** A column of numbers, its unit below its name. */
export function number(head: string, unit?: string): Column {
  return { head, isNumber: true, ...(unit && { unit }) };
}

export function numbers(...heads: string[]): Column[] {
  return heads.map((head) => number(head));
}

/** A column whose cells say enough to those who see them. */
export function unseen(head: string): Column {
  return { head: <VisuallyHidden>{head}</VisuallyHidden> };
}

/** above: a row over the heads that groups them. children: rows. tight: little room between columns. */
type Props = {
  label: string;
  columns: readonly Column[];
  above?: ReactNode;
  children: ReactNode;
  mostHeight?: string;
  tight?: boolean;
};

/** A table that scrolls in its own frame where it does not fit; cells with `data-number` stand to the right. */
export function WideTable({ label, columns, above, children, mostHeight, tight = false }: Props) {
  const style = mostHeight ? { "--most-height": mostHeight } : undefined;
  return (
    <div className={styles.frame} role="region" aria-label={`${label}: table`} tabIndex={0} style={style as React.CSSProperties}>
      <Table className={styles.table} data-tall={mostHeight ? true : undefined} verticalSpacing={6} horizontalSpacing={tight ? 6 : "sm"} highlightOnHover>
        <Table.Thead>
          {above}
          <Table.Tr>
            {columns.map((column, k) => (
              <Head key={k} column={typeof column === "string" ? { head: column } : column} />
            ))}
          </Table.Tr>
        </Table.Thead>
        <Table.Tbody>{children}</Table.Tbody>
      </Table>
    </div>
  );
}

function Head({ column: { head, unit, isNumber, className } }: { column: Exclude<Column, string> }) {
  return (
    <Table.Th scope="col" className={className} data-number={isNumber || undefined}>
      {head}
      {unit && (
        <>
          <br />
          <span className={styles.unit}>[{unit}]</span>
        </>
      )}
    </Table.Th>
  );
}
