import { Alert, List } from "@mantine/core";
import { IconAlertCircle } from "@tabler/icons-react";

import type { DeviceSummary } from "../../api/devices";
import { count } from "../../parts/size";
import styles from "./Doubts.module.css";

/** What looks like a slip in the device file, and what to know when reading the figures. */
export function Doubts({ summary }: { summary: DeviceSummary }) {
  const { warnings = [], notes = [] } = summary;
  if (warnings.length + notes.length === 0) return null;
  return (
    <Alert color="yellow" icon={<IconAlertCircle aria-hidden />} title={`The check has ${count(warnings.length + notes.length, "remark")}`} className={styles.box}>
      <List size="sm" spacing={4}>
        {warnings.map((doubt, k) => (
          <List.Item key={k}>
            {doubt.row !== null && <strong>line {doubt.row}: </strong>}
            {doubt.detail}. {doubt.advice}
          </List.Item>
        ))}
        {notes.map((note) => (
          <List.Item key={note}>{note}</List.Item>
        ))}
      </List>
    </Alert>
  );
}
