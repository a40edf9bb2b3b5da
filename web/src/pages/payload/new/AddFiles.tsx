import { Button, Checkbox, Group, Paper, Progress, Text } from "@mantine/core";
import { useEffect, useRef, useState, type ReactNode } from "react";

import { upload } from "../../../api/upload";
import { DropFiles, type Dropped } from "../../../parts/DropFiles";
import { ProblemBox } from "../../../parts/ProblemBox";
import { sizeOf } from "../../../parts/size";
import type { DraftFile } from "./useDraft";

type Props = { title: string; take: (files: DraftFile[], together: boolean) => void; several?: boolean; children: ReactNode };

/** Files are sent as they are dropped, one after the other. several: they may be parts of one log. */
export function AddFiles({ title, take, several = false, children }: Props) {
  const [sending, setSending] = useState<{ name: string; sent: number; size: number } | null>(null);
  const [error, setError] = useState<unknown>(null);
  const [together, setTogether] = useState(false);
  const stopper = useRef<AbortController | null>(null);
  useEffect(() => () => stopper.current?.abort(), []);

  async function send(files: Dropped): Promise<void> {
    const stop = new AbortController();
    stopper.current = stop;
    setError(null);
    const sent: DraftFile[] = [];
    try {
      for (const [path, file] of files) {
        const told = (bytes: number) => setSending({ name: path, sent: bytes, size: file.size });
        told(0);
        sent.push({ path: placed(path), upload: await upload(file, path, told, stop.signal) });
      }
    } catch (refused) {
      if (!stop.signal.aborted) setError(refused);
    }
    setSending(null);
    stopper.current = null; // to leave the step later removes nothing that has arrived
    if (sent.length > 0 && !stop.signal.aborted) take(sent, together && sent.length > 1);
  }

  if (sending) {
    return (
      <Paper withBorder p="md" role="status">
        <Group justify="space-between">
          <Text>
            {sending.name}: {sizeOf(sending.sent)} of {sizeOf(sending.size)}
          </Text>
          <Button variant="default" onClick={() => stopper.current?.abort()}>
            Stop
          </Button>
        </Group>
        <Progress aria-label={sending.name} value={sending.size ? (100 * sending.sent) / sending.size : 100} mt="sm" />
      </Paper>
    );
  }
  return (
    <>
      <DropFiles title={title} choose="Choose files" take={(files) => void send(files)}>
        {children}
      </DropFiles>
      {several && (
        <Checkbox
          mt="xs"
          label="What I drop next is one log in several files, each with its own clock or rate"
          checked={together}
          onChange={(event) => setTogether(event.currentTarget.checked)}
        />
      )}
      {error !== null && <ProblemBox error={error} />}
    </>
  );
}

/** URDF and meshes keep their places, logs lie in a folder of their own. */
function placed(path: string): string {
  return /\.(urdf|xml|stl|dae|obj|ply)$/i.test(path) || path.includes("/") ? path : `logs/${path}`;
}
