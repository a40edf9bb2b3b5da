import { keepPreviousData, useInfiniteQuery, useMutation, useQuery, useQueryClient } from "@tanstack/react-query";

import { answer, api, type Schemas } from "./client";
import { bundle } from "./robots";

export type Arm = { joint: string; arm_m: number; pulls: string };
export type BandSummary = {
  name: string;
  group: string;
  links: string[];
  stiffness_n_per_m: number | null;
  natural_length_m: number | null;
  ground_truth: boolean;
  law: string;
  bench_points: number | null;
  length_at_zero_m: number;
  tension_at_zero_n: number | null;
  arms_at_zero: Arm[];
};
export type Doubt = {
  detail: string;
  rule: string;
  advice: string;
  file: string | null;
  row: number | null;
  column: string | null;
  value: string | null;
};
export type DeviceSummary = {
  name: string;
  robot: string;
  groups: string[];
  joints: string[];
  bands: BandSummary[];
  torque_at_zero_n_m: Record<string, number>;
  warnings: Doubt[];
  notes: string[];
};
export type Device = Omit<Schemas["DeviceOut"], "summary"> & { summary: DeviceSummary };

export type BandLaw = Schemas["LawOut"];

const PAGE = 100;

/** Newest first; each version is one of them. */
export function useDevices(of: { search?: string; name?: string; robot_id?: string } = {}) {
  return useInfiniteQuery({
    queryKey: ["devices", of],
    placeholderData: of.search ? keepPreviousData : undefined, // never those of another robot
    queryFn: ({ pageParam, signal }) =>
      answer(api.GET("/api/v1/devices", { params: { query: { limit: PAGE, cursor: pageParam, ...of } }, signal })),
    initialPageParam: undefined as string | undefined,
    getNextPageParam: (page) => page.next_cursor ?? undefined,
    select: ({ pages }) => pages.flatMap((page) => page.items) as Device[],
  });
}

export function useDevice(id: string) {
  return useQuery({
    queryKey: ["devices", id],
    staleTime: Infinity,
    queryFn: ({ signal }) =>
      answer(api.GET("/api/v1/devices/{device_id}", { params: { path: { device_id: id } }, signal })) as Promise<Device>,
  });
}

/** How a band may pull, as device.yaml says it. */
export function useBandLaws() {
  return useQuery({
    queryKey: ["band-laws"],
    staleTime: Infinity,
    queryFn: ({ signal }) => answer(api.GET("/api/v1/band-laws", { signal })),
    select: ({ laws }) => laws,
  });
}

/** device.yaml and the bench tests that it names, on a robot. */
export function useAddDevice() {
  const cache = useQueryClient();
  return useMutation({
    mutationFn: ({ files, robot }: { files: Map<string, Blob>; robot: string }) =>
      answer(
        api.POST("/api/v1/devices", { body: bundle(files, { robot }) as never, bodySerializer: (form) => form }),
      ) as Promise<Device>,
    onSuccess: () => cache.invalidateQueries({ queryKey: ["devices"] }),
  });
}
