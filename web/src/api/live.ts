/** Live streams of a payload's sensor: their list, and one that runs, as everybody may watch it. */

import { useQuery } from "@tanstack/react-query";
import { useEffect, useState } from "react";

import { address } from "../app/base";
import { answer, api, type Schemas } from "./client";

export type LiveStream = Schemas["LiveStreamOut"];
type WrenchSaid = { type: "wrench"; t: number[]; wrench: number[][]; std: number[][]; alarm: boolean[]; settled: boolean[] };
export type PayloadSaid = {
  type: "payload";
  t: number;
  state: "static" | "converging" | "converged" | "frozen";
  value: Record<string, number>;
  std: Record<string, number>;
  decided: string[];
  mu: number | null;
  mu_std: number | null;
  threshold_n: number | null;
  late_ms: number | null;
  late_std_ms: number | null;
  in_doubt: string[];
  calibration: string;
  counts: Record<string, number>;
};
type Said = WrenchSaid | PayloadSaid | { type: "missed"; messages: number } | { type: "error"; detail: string } | { type: "stream" | "welcome" | "ended" };

/** force: the largest during it. to: its last sample by now. */
export type Alarm = { from: number; to: number; lasts: boolean; force: number[] };

/** What was known by then. */
export type Course = { t: number[]; value: Record<string, number>[]; std: Record<string, number>[] };

/** t: [s] of the sender's clock. wrench: six traces, null where nothing is settled. course: of the estimates, since
watching began, the older the sparser. */
export type Watched = {
  line: "opening" | "open" | "closed";
  t: number[];
  wrench: (number | null)[][];
  std: number[];
  alarms: Alarm[];
  payload: PayloadSaid | null;
  first: PayloadSaid | null;
  course: Course;
  missed: number;
  error: string | null;
};

const LISTED = 20;
const SOON_MS = 3_000;
const SHOWN_S = 20;
const KEPT = 600; // estimates of a course
const ALARMS = 50;
const DRAWN_EVERY_MS = 200;
const AGAIN_MS = 3_000;
const SAME_S = 0.3; // between two alarms that are one touch

export function useStreams(payloadId: string) {
  return useQuery({
    queryKey: ["payloads", payloadId, "streams"],
    queryFn: ({ signal }) =>
      answer(api.GET("/api/v1/payloads/{payload_id}/streams", { params: { path: { payload_id: payloadId }, query: { limit: LISTED } }, signal })),
    select: ({ items }) => items,
    refetchInterval: SOON_MS,
  });
}

/** What is seen of a stream that runs, drawn anew five times a second; a line that breaks is opened again. */
export function useWatched(payloadId: string, streamId: string): Watched {
  const [shown, show] = useState<Watched>(nothing);
  useEffect(() => {
    const seen = nothing();
    let line: WebSocket | null = null;
    let news = false;
    let again = 0;
    const open = () => {
      const where = new URL(address(`api/v1/live/payload/${payloadId}/watch?stream=${streamId}`));
      where.protocol = where.protocol === "https:" ? "wss:" : "ws:";
      line = new WebSocket(where);
      line.onmessage = ({ data }) => {
        take(seen, JSON.parse(data as string) as Said);
        news = true;
      };
      line.onclose = () => {
        seen.line = "closed";
        news = true;
        again = window.setTimeout(open, AGAIN_MS);
      };
    };
    open();
    const drawing = window.setInterval(() => {
      if (news) show({ ...seen, t: [...seen.t], wrench: seen.wrench.map((trace) => [...trace]), alarms: [...seen.alarms], course: { ...seen.course, t: [...seen.course.t] } });
      news = false;
    }, DRAWN_EVERY_MS);
    return () => {
      window.clearInterval(drawing);
      window.clearTimeout(again);
      if (line) line.onclose = null;
      line?.close();
    };
  }, [payloadId, streamId]);
  return shown;
}

function nothing(): Watched {
  return { line: "opening", t: [], wrench: [[], [], [], [], [], []], std: [], alarms: [], payload: null, first: null, course: { t: [], value: [], std: [] }, missed: 0, error: null };
}

function take(seen: Watched, said: Said): void {
  seen.line = "open";
  if (said.type === "wrench") takeWrench(seen, said);
  else if (said.type === "payload") {
    seen.payload = said;
    seen.first ??= said;
    takeEstimate(seen.course, said);
  } else if (said.type === "missed") seen.missed = said.messages;
  else if (said.type === "error") seen.error = said.detail;
}

/** When there are too many, every second one goes: the course stays whole. */
function takeEstimate({ t, value, std }: Course, said: PayloadSaid): void {
  t.push(said.t);
  value.push(said.value);
  std.push(said.std);
  if (t.length <= KEPT) return;
  for (const each of [t, value, std] as unknown[][]) each.splice(0, each.length, ...each.filter((_, k) => k % 2 === 0));
}

function takeWrench(seen: Watched, { t, wrench, std, alarm, settled }: WrenchSaid): void {
  t.forEach((time, k) => {
    seen.t.push(time);
    seen.wrench.forEach((trace, axis) => trace.push(settled[k] ? wrench[k]![axis]! : null));
    if (alarm[k]) takeAlarm(seen, time, wrench[k]!.slice(0, 3));
  });
  const latest = t.at(-1);
  if (latest === undefined) return;
  seen.std = std.at(-1)!;
  const last = seen.alarms.at(-1);
  if (last?.lasts && latest - last.to > SAME_S) seen.alarms[seen.alarms.length - 1] = { ...last, lasts: false };
  const old = seen.t.findIndex((time) => time >= latest - SHOWN_S);
  if (old > 0) for (const each of [seen.t, ...seen.wrench]) each.splice(0, old);
}

function takeAlarm(seen: Watched, time: number, force: number[]): void {
  const last = seen.alarms.at(-1);
  if (last?.lasts && time - last.to <= SAME_S) {
    const larger = Math.hypot(...force) > Math.hypot(...last.force);
    seen.alarms[seen.alarms.length - 1] = { ...last, to: time, force: larger ? force : last.force };
    return;
  }
  seen.alarms.push({ from: time, to: time, lasts: true, force });
  if (seen.alarms.length > ALARMS) seen.alarms.shift();
}
