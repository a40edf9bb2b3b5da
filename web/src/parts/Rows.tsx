import { Paper } from "@mantine/core";
import type { ReactNode } from "react";

import styles from "./Rows.module.css";

/** A list of things, each a `Row`. */
export function Rows({ children }: { children: ReactNode }) {
  return <ul className={styles.rows}>{children}</ul>;
}

/** One thing: what it is, and beside it whatever follows. */
export function Row({ words, children }: { words: ReactNode; children: ReactNode }) {
  return (
    <Paper withBorder component="li" className={styles.row}>
      <div className={styles.words}>{words}</div>
      {children}
    </Paper>
  );
}

/** Small facts at the end of a row. */
export function AtRight({ children }: { children: ReactNode }) {
  return <div className={styles.right}>{children}</div>;
}
