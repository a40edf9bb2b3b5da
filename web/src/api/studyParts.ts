/** A robot or a device of a study, taken over into the lists of robots and devices. */

import { useMutation, useQueryClient } from "@tanstack/react-query";

import { answer, api } from "./client";
import type { Device } from "./devices";
import { fetchFile } from "./files";
import { bundle, fileAddress, listsChanged, type Robot } from "./robots";
import type { Study } from "./studies";

type Summary = { robot?: { file?: string; name?: string }; devices?: { file: string; name: string }[] };

export function partsOf(study: Study): Summary {
  return study.summary as Summary;
}

/** robot.yaml and the URDF that it names. */
async function addRobot(study: Study): Promise<Robot> {
  const path = partsOf(study).robot?.file ?? "robot.yaml";
  const { parse } = await import("yaml");
  const description = await fetchFile(fileAddress("studies", study.id, path));
  const urdf = (parse(await description.text()) as { urdf: string }).urdf;
  const files = new Map([
    ["robot.yaml", description],
    [urdf, await fetchFile(fileAddress("studies", study.id, urdf))],
  ]);
  const asked = api.POST("/api/v1/robots", { body: bundle(files) as never, bodySerializer: (form) => form });
  return answer(asked) as Promise<Robot>;
}

/** The device file and its bench tests, on the study's robot. */
async function addDevice(study: Study, path: string): Promise<Device> {
  const robot = await addRobot(study);
  const { parse } = await import("yaml");
  const description = await fetchFile(fileAddress("studies", study.id, path));
  const content = parse(await description.text()) as { bands?: { bench?: { file: string } }[] };
  const files = new Map([["device.yaml", description]]);
  for (const { bench } of content.bands ?? []) {
    if (bench && !files.has(bench.file)) {
      files.set(bench.file, await fetchFile(fileAddress("studies", study.id, bench.file)));
    }
  }
  const form = bundle(files, { robot: robot.id });
  return answer(api.POST("/api/v1/devices", { body: form as never, bodySerializer: (same) => same })) as Promise<Device>;
}

export function useTakeRobot() {
  const cache = useQueryClient();
  return useMutation({
    mutationFn: addRobot,
    onSuccess: () => listsChanged(cache),
  });
}

export function useTakeDevice() {
  const cache = useQueryClient();
  return useMutation({
    mutationFn: ({ study, file }: { study: Study; file: string }) => addDevice(study, file),
    onSuccess: () => listsChanged(cache),
  });
}
