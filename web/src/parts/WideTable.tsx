import { Table } from "@mantine/core";
import type { ReactNode } from "react";

import styles from "./WideTable.module.css";

/** tight: little room between columns. */
type Props = { label: string; children: ReactNode; mostHeight?: string; tight?: boolean };

/** A table that scrolls in its own frame where it does not fit; cells with `data-number` stand to the right. */
export function WideTable({ label, children, mostHeight, tight = false }: Props) {
  const style = mostHeight ? { "--most-height": mostHeight } : undefined;
  return (
    <div className={styles.frame} role="region" aria-label={`${label}: table`} tabIndex={0} style={style as React.CSSProperties}>
      <Table className={styles.table} verticalSpacing={6} horizontalSpacing={tight ? 6 : "sm"} highlightOnHover>
        {children}
      </Table>
    </div>
  );
}

/** The unit below a column's name. */
export function Unit({ children }: { children: ReactNode }) {
  return (
    <>
      <br />
      <span className={styles.unit}>[{children}]</span>
    </>
  );
}
