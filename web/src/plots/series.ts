/** A series of a job: what it holds, tiles of them to draw, single samples to read. */

import { keepPreviousData, useQuery } from "@tanstack/react-query";

import { answer, api, type Schemas } from "../api/client";
import type { paths } from "../api/schema";

export type Tiles = Schemas["TilesOut"];
export type SeriesFacts =
  paths["/api/v1/jobs/{job_id}/series"]["get"]["responses"]["200"]["content"]["application/json"]["items"][number];

/** What one series holds; null where the job made none of that name. */
export function useSeries(jobId: string, name: string | undefined) {
  return useQuery({
    queryKey: ["series", jobId, name],
    queryFn: async ({ signal }): Promise<SeriesFacts | null> => {
      const asked = { path: { job_id: jobId }, query: { name } };
      const { items } = await answer(api.GET("/api/v1/jobs/{job_id}/series", { params: asked, signal }));
      return items[0] ?? null;
    },
    staleTime: Infinity,
    enabled: name !== undefined,
  });
}

export type TilesAsked = {
  jobId: string;
  name: string;
  channels: string[];
  start: number;
  end: number;
  width: number;
};

/** Minimum and maximum of each stretch of the window; what was shown before stays until they are there. */
export function useTiles(asked: TilesAsked) {
  return useQuery({
    queryKey: ["tiles", asked.jobId, asked.name, asked.channels, asked.start, asked.end, asked.width],
    queryFn: ({ signal }) => tilesOf(asked, signal),
    placeholderData: keepPreviousData,
    staleTime: Infinity,
    gcTime: 60_000,
    enabled: asked.width > 0 && asked.channels.length > 0,
  });
}

function tilesOf({ jobId, name, channels, start, end, width }: TilesAsked, signal: AbortSignal): Promise<Tiles> {
  return answer(
    api.GET("/api/v1/jobs/{job_id}/series/{name}/tiles", {
      params: { path: { job_id: jobId, name }, query: { channels, start, end, width } },
      signal,
    }),
  );
}

export type Sample = { t: number; values: Record<string, number | null> };

/** The sample next to a time, from the file itself: what a reader may write down. */
export function useSample(jobId: string, name: string, channels: string[], at: number | null) {
  return useQuery({
    queryKey: ["sample", jobId, name, channels, at],
    queryFn: async ({ signal }): Promise<Sample | null> => {
      const time = at ?? 0;
      const found = await tilesOf({ jobId, name, channels, start: time, end: time, width: 8 }, signal);
      const k = nearest(found.t, time);
      if (k < 0) return null;
      const values = Object.fromEntries(channels.map((each) => [each, found.channels[each]?.min[k] ?? null]));
      return { t: found.t[k] as number, values };
    },
    staleTime: Infinity,
    gcTime: 30_000,
    enabled: at !== null && channels.length > 0,
  });
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
