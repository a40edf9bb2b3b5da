import { Button, Group, Paper, Progress, Stack, Text, Title } from "@mantine/core";

import { useAway } from "../../api/reachable";
import { count, sizeOf } from "../../parts/size";
import { totalSize, type Picked } from "./picked";
import type { Progress as Sent } from "./send";
import styles from "./SendingFiles.module.css";

const MOST = 6;

type Props = { files: Picked[]; progress: Sent; stop: () => void };

/** What is on its way: all of it in one bar, and the files that are next, each with its own. */
export function SendingFiles({ files, progress, stop }: Props) {
  const waiting = useAway()?.signedOut;
  const size = totalSize(files);
  const sent = progress.sent.reduce((sum, part) => sum + part, 0);
  const rows = files.map(({ file, path }, k) => ({ path, size: file.size, sent: progress.sent[k] ?? 0 }));
  const open = rows.filter((row) => row.sent < row.size);
  const arrived = rows.length - open.length;
  const shown = (rows.length <= MOST ? rows : open).slice(0, MOST);
  const percent = size ? Math.round((100 * sent) / size) : 100;
  return (
    <Paper withBorder p="lg" component="section" aria-labelledby="sending">
      <Group justify="space-between" align="flex-start">
        <div>
          <Title order={2} size="h3" id="sending">
            {waiting ? "Waiting until you have signed in" : progress.reading ? "The service reads the files …" : "Sending"}
          </Title>
          <Text size="sm" c="dimmed" role="status">
            {progress.reading
              ? `${count(files.length, "file")}, ${sizeOf(size)}, arrived; every log is checked now.`
              : `${sizeOf(sent)} of ${sizeOf(size)}, ${arrived} of ${count(files.length, "file")}`}
          </Text>
        </div>
        <Button variant="default" onClick={stop}>
          Stop
        </Button>
      </Group>
      <Progress value={percent} aria-label="All files" mt="sm" size="lg" animated={progress.reading} striped={progress.reading} />
      {!progress.reading && (
        <Stack component="ul" gap={6} className={styles.files}>
          {shown.map((row) => (
            <li key={row.path}>
              <Group justify="space-between" gap="xs" wrap="nowrap">
                <Text size="sm" truncate>
                  {row.path}
                </Text>
                <Text size="sm" c="dimmed" className={styles.size}>
                  {sizeOf(row.size)}
                </Text>
              </Group>
              <Progress value={row.size ? (100 * row.sent) / row.size : 100} size="sm" aria-label={row.path} />
            </li>
          ))}
          {open.length > shown.length && <li>… and {open.length - shown.length} more</li>}
        </Stack>
      )}
    </Paper>
  );
}
