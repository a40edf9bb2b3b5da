import type { ReactNode } from "react";

import styles from "./FactList.module.css";

/** Names and what they are, one below the other. */
export function FactList({ facts }: { facts: [string, ReactNode][] }) {
  return (
    <dl className={styles.list}>
      {facts.map(([name, what]) => (
        <div key={name} style={{ display: "contents" }}>
          <dt>{name}</dt>
          <dd>{what}</dd>
        </div>
      ))}
    </dl>
  );
}
