import { keepPreviousData, useInfiniteQuery, useMutation, useQuery, useQueryClient, type QueryClient } from "@tanstack/react-query";

import { address } from "../app/base";
import { answer, api, type Schemas } from "./client";

/** Places are seen from the base link with all joints at zero: at [m], turn: its 3 × 3 rotation row by row. */
export type Place = { at: number[]; turn: number[] };
export type RobotLink = Place & {
  name: string;
  body: string;
  joint: string | null;
  mass_kg: number | null;
  centre: number[] | null;
};
export type DriveValues = Record<string, number | undefined>;
export type RobotJoint = {
  name: string;
  kind: "revolute" | "prismatic";
  moves: string;
  actuation: "current" | "torque" | "none";
  gear_ratio: number | null;
  prior: DriveValues;
  prior_std: DriveValues;
  lower: number | null;
  upper: number | null;
  velocity: number | null;
  effort: number | null;
};
export type RobotSensor = { name: string; frame: string; role: "contact" | "cut"; sees: string };
export type RobotModel = {
  base_link: string;
  joints: RobotJoint[];
  links: RobotLink[];
  bones: number[][][];
  transmission: { joints: string[]; matrix: number[][] } | null;
  imu: (Place & { on: string | null }) | null;
  sensors: RobotSensor[];
  locked: string[];
  noise: Record<string, number>;
  inertial_std: Record<string, number>;
};
export type RobotSummary = {
  name: string;
  urdf?: string;
  base: "floating" | "fixed";
  joints: string[];
  sensors: string[];
  mass_kg: number;
  /** What of robot.yaml is for planned motions; nothing of a robot that was handed in before this was told. */
  motion?: { soles: number; human_map: string[]; home: boolean };
  model?: RobotModel;
};
export type Robot = Omit<Schemas["RobotOut"], "summary"> & { summary: RobotSummary };

const PAGE = 100;

/** Newest first; each version is one of them. Those with the words, where given. */
export function useRobots(of: { search?: string } = {}) {
  return useInfiniteQuery({
    queryKey: ["robots", of],
    placeholderData: keepPreviousData,
    queryFn: ({ pageParam, signal }) =>
      answer(api.GET("/api/v1/robots", { params: { query: { limit: PAGE, cursor: pageParam, ...of } }, signal })),
    initialPageParam: undefined as string | undefined,
    getNextPageParam: (page) => page.next_cursor ?? undefined,
    select: ({ pages }) => pages.flatMap((page) => page.items) as Robot[],
  });
}

export function useRobot(id: string | undefined) {
  return useQuery({
    queryKey: ["robots", id],
    enabled: id !== undefined && id !== "",
    staleTime: Infinity,
    queryFn: ({ signal }) =>
      answer(api.GET("/api/v1/robots/{robot_id}", { params: { path: { robot_id: id ?? "" } }, signal })) as Promise<Robot>,
  });
}

/** Paths and contents; robot.yaml at the top. */
export function useAddRobot() {
  const cache = useQueryClient();
  return useMutation({
    mutationFn: (files: Map<string, Blob>) =>
      answer(api.POST("/api/v1/robots", { body: bundle(files) as never, bodySerializer: (form) => form })) as Promise<Robot>,
    onSuccess: () => listsChanged(cache),
  });
}

/** A robot more: studies may be of it. */
export function listsChanged(cache: QueryClient) {
  return Promise.all([["robots"], ["devices"], ["studies"]].map((queryKey) => cache.invalidateQueries({ queryKey })));
}

export function bundle(files: Map<string, Blob>, fields: Record<string, string> = {}): FormData {
  const form = new FormData();
  for (const [path, content] of files) form.append("files", content, path);
  for (const [name, value] of Object.entries(fields)) form.append(name, value);
  return form;
}

export function fileAddress(kind: "robots" | "devices" | "studies" | "payloads" | "motions" | "plans", id: string, path: string): string {
  return address(`api/v1/${kind}/${id}/files/${path.split("/").map(encodeURIComponent).join("/")}`);
}
