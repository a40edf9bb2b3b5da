/** The draft of a payload: kept in this tab until it is a payload, and taken up again from one that is stored. */

import { useDebouncedValue } from "@mantine/hooks";
import { useEffect, useMemo, useState } from "react";

import { keepDraft, useLook, useVerdict, type DraftBody } from "../../../api/payloadDrafts";
import type { Payload } from "../../../api/payloads";
import { fileAddress } from "../../../api/robots";
import { answer, api } from "../../../api/client";
import { contentOf, EMPTY, named, ofRobot, textOf, wayOf, type Content } from "./content";

const STORE = "exogauge-payload-draft";
const PAUSE_MS = 400;
const MAIN = "payload.yaml";
const MESH = /\.(stl|dae|obj|ply)$/i;

/** upload: where the file has been sent; without, it is one of `base`. */
export type DraftFile = { path: string; upload?: string };
/** base: the stored payload that this goes on from. saved: what was kept as it. planned: versions that have plans. */
export type Draft = { content: Content; files: DraftFile[]; base: string | null; saved: string | null; planned: string[] };

const NEW: Draft = { content: EMPTY, files: [], base: null, saved: null, planned: [] };

export type Drafted = ReturnType<typeof useDraft>;

export function useDraft(from: string | null, doctor: boolean) {
  const [draft, setDraft] = useState<Draft>(() => restored(from) ?? NEW);
  const [failed, setFailed] = useState<unknown>(null);
  const opening = from !== null && draft.base !== from;
  useEffect(() => {
    if (!opening) return;
    let gone = false;
    setFailed(null);
    opened(from).then((found) => !gone && setDraft(found)).catch((error: unknown) => !gone && setFailed(error));
    return () => {
      gone = true;
    };
  }, [from, opening]);
  useEffect(() => store(draft), [draft]);

  const set = (change: (content: Content) => Content) => setDraft((now) => ({ ...now, content: change(now.content) }));
  const whole = useMemo(() => bodyOf(draft, draft.files), [draft]);
  const look = useLook(whole);
  const body = useMemo(() => bodyOf(draft, needed(draft)), [draft]);
  const [settled] = useDebouncedValue(body, PAUSE_MS);
  const verdict = useVerdict(settled, doctor);

  useEffect(() => {
    const seen = look.data;
    if (!seen || look.isPlaceholderData || opening) return;
    const robot = seen.robots[0];
    set((now) => named(robot && wayOf(now) === "joints" && now.pose.urdf !== robot.file ? ofRobot(now, robot) : now, seen));
  }, [look.data, look.isPlaceholderData, opening]);

  return {
    draft,
    set,
    opening,
    failed,
    look: look.data,
    looking: look.isFetching,
    lookError: look.error,
    verdict: verdict.data,
    judging: verdict.isFetching || settled !== body,
    verdictError: verdict.error,
    robot: look.data?.robots.find(({ file }) => file === draft.content.pose.urdf) ?? look.data?.robots[0],
    add: (files: DraftFile[]) => setDraft((now) => ({ ...now, files: [...now.files.filter(({ path }) => files.every((each) => each.path !== path)), ...files] })),
    remove: (path: string) =>
      setDraft((now) => ({
        ...now,
        files: now.files.filter((file) => file.path !== path),
        content: { ...now.content, logs: now.content.logs.filter(({ file }) => !file.includes(path)) },
      })),
    anew: () => setDraft(NEW),
    /** Kept as a payload, once for what is written now. */
    keep: async (): Promise<string> => {
      const wanted = JSON.stringify(body);
      if (draft.base && draft.saved === wanted) return draft.base;
      const kept = await keepDraft(body);
      setDraft((now) => afterKeeping(now, kept));
      return kept.id;
    },
    planned: (id: string) => setDraft((now) => ({ ...now, planned: [id, ...now.planned.filter((each) => each !== id)] })),
    text: body.text ?? "",
  };
}

function afterKeeping(now: Draft, kept: Payload): Draft {
  const there = new Set((kept.files ?? []).map(({ path }) => path));
  const files = now.files.filter(({ path, upload }) => upload || there.has(path)).map((file) => (there.has(file.path) ? { path: file.path } : file));
  const next = { ...now, base: kept.id, files };
  return { ...next, saved: JSON.stringify(bodyOf(next, needed(next))) };
}

/** Files that payload.yaml names, and meshes beside them. */
function needed({ content, files }: Draft): DraftFile[] {
  const names = new Set([content.pose.urdf, ...content.logs.flatMap(({ file }) => file)]);
  return files.filter(({ path }) => names.has(path) || MESH.test(path));
}

function bodyOf({ content, base }: Draft, files: DraftFile[]): DraftBody {
  const sent = files.filter(({ upload }) => upload);
  return {
    base_id: base,
    keep: files.filter(({ upload }) => !upload).map(({ path }) => path),
    upload_ids: sent.map(({ upload }) => upload ?? ""),
    paths: sent.map(({ path }) => path),
    text: textOf(content),
  };
}

async function opened(id: string): Promise<Draft> {
  const payload = (await answer(api.GET("/api/v1/payloads/{payload_id}", { params: { path: { payload_id: id } } }))) as Payload;
  const files = payload.files ?? [];
  const text = await (await fetch(fileAddress("payloads", id, MAIN))).text();
  const draft = { ...NEW, content: contentOf(text), base: id, planned: [id], files: files.filter(({ path }) => path !== MAIN).map(({ path }) => ({ path })) };
  return { ...draft, saved: JSON.stringify(bodyOf(draft, needed(draft))) };
}

/** What this tab holds, unless another payload is asked for; a draft that was kept as it stands is done with. */
function restored(from: string | null): Draft | null {
  try {
    const kept = JSON.parse(sessionStorage.getItem(STORE) ?? "null") as Draft | null;
    if (!kept) return null;
    if (from !== null) return kept.base === from ? kept : null;
    return kept.saved === JSON.stringify(bodyOf(kept, needed(kept))) ? null : kept;
  } catch {
    return null;
  }
}

function store(draft: Draft): void {
  try {
    sessionStorage.setItem(STORE, JSON.stringify(draft));
  } catch {
    // this browser keeps nothing
  }
}

