/** A series: what it holds, tiles of them to draw, single samples to read. */

import { keepPreviousData, useQuery } from "@tanstack/react-query";

import { answer, api, type Schemas } from "../api/client";
import type { paths } from "../api/schema";

export type Tiles = Schemas["TilesOut"];
export type SeriesFacts =
  paths["/api/v1/jobs/{job_id}/series"]["get"]["responses"]["200"]["content"]["application/json"]["items"][number];

/** A job that made series; a study, whose logs are series as they were read; a motion, which is one. */
export type Source = { of: "jobs" | "studies" | "motions"; id: string };

/** What one series holds; null where the job made none of that name. */
export function useSeries(source: Source, name: string | undefined) {
  return useQuery({
    queryKey: ["series", source.id, name],
    queryFn: ({ signal }) => factsOf(source, name ?? "", signal),
    staleTime: Infinity,
    enabled: name !== undefined,
  });
}

async function factsOf({ of, id }: Source, name: string, signal: AbortSignal): Promise<SeriesFacts | null> {
  if (of === "studies") {
    return answer(api.GET("/api/v1/studies/{study_id}/series/{name}", { params: { path: { study_id: id, name } }, signal }));
  }
  if (of === "motions") return answer(api.GET("/api/v1/motions/{motion_id}/series", { params: { path: { motion_id: id } }, signal }));
  const asked = { path: { job_id: id }, query: { name } };
  const { items } = await answer(api.GET("/api/v1/jobs/{job_id}/series", { params: asked, signal }));
  return items[0] ?? null;
}

export type TilesAsked = {
  source: Source;
  name: string;
  channels: string[];
  start: number;
  end: number;
  width: number;
};

/** Minimum and maximum of each stretch of the window; what was shown before stays until they are there. */
export function useTiles(asked: TilesAsked) {
  return useQuery({
    queryKey: ["tiles", asked.source.id, asked.name, asked.channels, asked.start, asked.end, asked.width],
    queryFn: ({ signal }) => tilesOf(asked, signal),
    placeholderData: keepPreviousData,
    staleTime: Infinity,
    gcTime: 60_000,
    enabled: asked.width > 0 && asked.channels.length > 0,
  });
}

function tilesOf({ source, name, channels, start, end, width }: TilesAsked, signal: AbortSignal): Promise<Tiles> {
  const query = { channels, start, end, width };
  if (source.of === "studies") {
    const path = { study_id: source.id, name };
    return answer(api.GET("/api/v1/studies/{study_id}/series/{name}/tiles", { params: { path, query }, signal }));
  }
  if (source.of === "motions") {
    const path = { motion_id: source.id };
    return answer(api.GET("/api/v1/motions/{motion_id}/series/tiles", { params: { path, query }, signal }));
  }
  const path = { job_id: source.id, name };
  return answer(api.GET("/api/v1/jobs/{job_id}/series/{name}/tiles", { params: { path, query }, signal }));
}

export type Sample = { t: number; values: Record<string, number | null> };

/** The sample next to a time, from the file itself: what a reader may write down. scale: of the file's values to those
that are told. */
export function useSample(source: Source, name: string, channels: string[], at: number | null, scale: number) {
  return useQuery({
    queryKey: ["sample", source.id, name, channels, at, scale],
    queryFn: async ({ signal }): Promise<Sample | null> => {
      const time = at ?? 0;
      const found = await tilesOf({ source, name, channels, start: time, end: time, width: 8 }, signal);
      const k = nearest(found.t, time);
      if (k < 0) return null;
      const values = Object.fromEntries(channels.map((each) => [each, times(found.channels[each]?.min[k], scale)]));
      return { t: found.t[k] as number, values };
    },
    staleTime: Infinity,
    gcTime: 30_000,
    enabled: at !== null && channels.length > 0,
  });
}

function times(value: number | null | undefined, scale: number): number | null {
  return value === null || value === undefined ? null : scale * value;
}

/** Index of the value next to `wanted` in ascending values; -1 where there is none. */
export function nearest(ascending: ArrayLike<number>, wanted: number): number {
  let low = 0;
  let high = ascending.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if ((ascending[middle] as number) <= wanted) low = middle;
    else high = middle;
  }
  if (high < 0) return -1;
  return Math.abs((ascending[low] as number) - wanted) <= Math.abs((ascending[high] as number) - wanted) ? low : high;
}
