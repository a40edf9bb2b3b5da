import { Alert, List, Loader, Text } from "@mantine/core";
import { IconCheck, IconInfoCircle } from "@tabler/icons-react";

import type { Preview } from "../../api/imports";
import { count } from "../../parts/size";
import styles from "./Verdict.module.css";

const MOST = 12;

/** 24 s at 500 Hz, 12000 samples: where the unit of time is wrong, this is where it shows. */
function lasts({ duration_s, rate_hz, samples }: NonNullable<Preview["clock"]>) {
  const rounded = (value: number) => Number(value.toPrecision(4)).toLocaleString("en", { maximumSignificantDigits: 4 });
  return `${rounded(duration_s)} s at ${rounded(rate_hz)} Hz, ${samples} samples`;
}

/** Whether the mapping makes a log, and if not, what is missing and what to do. */
export function Verdict({ answer, waiting, preview }: { answer: Preview | undefined; waiting: boolean; preview: Preview }) {
  if (!answer) return waiting ? <Text role="status">The mapping is tried …</Text> : null;
  const names = new Set(preview.columns.map(({ name }) => name));
  const elsewhere = answer.errors.filter((error) => !names.has(error.column ?? ""));
  const columns = [...new Set(answer.errors.map((error) => error.column ?? "").filter((name) => names.has(name)))];
  const busy = waiting && <Loader size="xs" aria-label="trying it anew" />;
  if (answer.complete) {
    return (
      <Alert role="status" variant="default" icon={<IconCheck aria-hidden />} title={<>This makes a log of {count(answer.channels.length, "channel")} {busy}</>} className={styles.good}>
        {answer.clock && <Text size="sm">{lasts(answer.clock)}</Text>}
        {answer.channels.join(", ")}
      </Alert>
    );
  }
  return (
    <Alert role="status" variant="default" icon={<IconInfoCircle aria-hidden />} title={<>Not a log yet {busy}</>} className={styles.open}>
      {answer.clock && <Text size="sm">{lasts(answer.clock)}</Text>}
      <List size="sm" spacing={4}>
        {columns.length > 0 && (
          <List.Item>
            Say what {count(columns.length, "column")} measure, or ignore them: {columns.slice(0, MOST).join(", ")}
            {columns.length > MOST && ", …"}
          </List.Item>
        )}
        {elsewhere.slice(0, MOST).map((error, k) => (
          <List.Item key={k}>
            {error.column && <strong>{error.column}: </strong>}
            {error.detail}. {error.advice}
          </List.Item>
        ))}
      </List>
    </Alert>
  );
}
