/** One file from its upload to the log: what is said of its columns, and what the service says to that. */

import { useDebouncedValue } from "@mantine/hooks";
import { useEffect, useMemo, useRef, useState } from "react";

import { usePreview, type Preview } from "../../api/imports";
import { upload } from "../../api/upload";
import { useKeep, useKept } from "../../app/kept";
import { choicesOf, mappingOf, type Mapping, type Whole } from "./choices";

const PAUSE_MS = 350;

export type Sending = { file: File; sent: number; error: unknown } | null;

export function useUploading() {
  const [sending, setSending] = useState<Sending>(null);
  const [uploadId, setUploadId] = useKept<string | undefined>("upload", undefined);
  const [stopper, setStopper] = useState<AbortController | null>(null);
  async function send(file: File): Promise<void> {
    const stop = new AbortController();
    setStopper(stop);
    setUploadId(undefined);
    setSending({ file, sent: 0, error: null });
    try {
      const id = await upload(file, file.name, (sent) => setSending({ file, sent, error: null }), stop.signal);
      setUploadId(id);
      setSending(null);
    } catch (error) {
      setSending(stop.signal.aborted ? null : { file, sent: 0, error });
    }
  }
  return { sending, uploadId, send, stop: () => stopper?.abort(), forget: () => setUploadId(undefined) };
}

type Said = { whole: Whole | null; text: string | null };

/** text: a mapping as somebody writes it, which then counts instead of the table. */
export function useMapping(uploadId: string | undefined, robotId: string | undefined, joints: string[]) {
  const first = usePreview(uploadId, robotId, undefined);
  const [whole, setWhole] = useState<Whole | null>(null);
  const [text, setText] = useState<string | null>(null);
  const preview = first.data;
  const fresh = preview?.upload_id === uploadId && !first.isPlaceholderData;
  const kept = useRef<Said | null>(null);
  useKeep<Said>(`mapping of ${uploadId}`, { whole, text }, (said) => (kept.current = said));
  useEffect(() => {
    if (!preview || !fresh) return setWhole(null);
    setWhole(kept.current?.whole ?? startOf(preview));
    setText(kept.current?.text ?? null);
    kept.current = null;
  }, [preview, fresh]);
  const mapping = useMemo(() => text ?? (whole && preview ? mappingOf(whole, preview, joints) : undefined), [text, whole, preview, joints]);
  const [settled] = useDebouncedValue(mapping, PAUSE_MS);
  const judged = usePreview(whole === null || settled === undefined ? undefined : uploadId, robotId, settled);
  const waiting = judged.isFetching || settled !== mapping;
  return { first, preview: fresh ? preview : undefined, whole, setWhole, text, setText, mapping, judged, waiting };
}

/** The robot's own mapping where there is one, else what is sure; suggestions wait for a person. */
function startOf(preview: Preview): Whole {
  const remembered = preview.remembered && choicesOf(preview.remembered as Mapping, preview);
  const fits = remembered && Object.values(remembered.columns).some((choice) => choice.means !== "" && choice.means !== "ignore");
  const empty = { columns: {}, frames: {}, rateHz: null, delay: 0, rest: {}, layout: null };
  return (fits ? remembered : choicesOf(preview.mapping as Mapping, preview)) ?? empty;
}
