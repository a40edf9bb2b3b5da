import { Group, NativeSelect, Stack, Text, Title } from "@mantine/core";
import { useQueries } from "@tanstack/react-query";
import { useMemo } from "react";

import type { Comparison } from "../../api/compare";
import { answer, api, whole } from "../../api/client";
import { Loading } from "../../parts/Loading";
import { ProblemBox } from "../../parts/ProblemBox";
import { TimePlot } from "../../parts/TimePlot";
import { jobNames } from "./heads";
import { laidOver, type Curve } from "./laidOver";
import type { Selection } from "./selection";
import styles from "./Matrix.module.css";

type Props = { comparison: Comparison; selection: Selection; select: (change: Partial<Selection>) => void };
type StudyLogs = { logs?: { name: string; role: string; motion: string | null; device: string | null }[]; devices?: { file: string; name: string }[] };
type Wanted = { job: string; log: string; name: string };

const SHOWN = [
  ["support_a", "A"],
  ["support_b", "B"],
  ["support_paired", "Paired"],
] as const;

/** The supporting torque of one joint over one motion, by every device and job. */
export function Overlay({ comparison, selection, select }: Props) {
  const main = comparison.support.find((row) => row.cells.some((cell) => cell?.main));
  const motion = selection.motion || main?.motion || comparison.support[0]?.motion || "";
  const motions = [...new Set(comparison.support.map((row) => row.motion))];
  const joints = [...new Set(comparison.support.filter((row) => row.motion === motion).map((row) => row.joint))];
  const usual = comparison.support.find((row) => row.motion === motion && row.cells.some((cell) => cell?.main))?.joint;
  const joint = joints.includes(selection.joint) ? selection.joint : (usual ?? joints[0] ?? "");
  const { wanted, error: lost } = useLogs(comparison, motion);
  const { curves, waiting, error } = useCurves(wanted, joint);
  const drawn = useMemo(() => laidOver(curves), [curves]);
  if (comparison.support.length === 0) return null;
  return (
    <Stack component="section" gap="sm" aria-labelledby="overlay">
      <Group justify="space-between" align="flex-end">
        <Title order={2} size="h3" id="overlay">
          Over the motion
        </Title>
        <Group gap="md" className={styles.controls}>
          <NativeSelect label="Motion" value={motion} data={motions} onChange={(event) => select({ motion: event.currentTarget.value, joint: "" })} />
          <NativeSelect label="Joint" value={joint} data={joints} onChange={(event) => select({ joint: event.currentTarget.value })} />
        </Group>
      </Group>
      {(error ?? lost) ? (
        <ProblemBox error={error ?? lost} />
      ) : drawn.lines.length > 0 ? (
        <TimePlot label={`Supporting torque on ${joint} over ${motion}, by device and approach`} unit="N·m" t={drawn.t} lines={drawn.lines} height={320} />
      ) : waiting ? (
        <Loading what="the curves" lines={2} />
      ) : (
        <Text>These evaluations stored no supporting torque of this joint over time.</Text>
      )}
      <Text size="sm" c="dimmed">
        First recorded run of each device, each from its own start. Drawn from the smallest and largest value of each stretch;
        the numbers above come from every sample.
      </Text>
    </Stack>
  );
}

/** The first log of each device over the motion, in each job's study. */
function useLogs(comparison: Comparison, motion: string): { wanted: Wanted[]; error: Error | null } {
  const names = jobNames(comparison);
  const studies = useQueries({
    queries: comparison.jobs.map((job) => ({
      queryKey: ["studies", job.study_id],
      staleTime: 60_000,
      queryFn: () => answer(api.GET("/api/v1/studies/{study_id}", { params: { path: { study_id: job.study_id } } })),
    })),
  });
  const wanted = comparison.jobs.flatMap((job, k) => {
    const { logs = [], devices = [] } = (studies[k]?.data?.summary ?? {}) as StudyLogs;
    const worn = logs.filter((log) => log.role === "with_device" && log.motion === motion);
    const first = [...new Map([...worn].reverse().map((log) => [log.device, log])).values()].reverse();
    return first.map((log) => {
      const device = devices.find(({ file }) => file === log.device)?.name ?? log.device ?? "";
      return { job: job.id, log: log.name, name: names.length > 1 ? `${names[k]}: ${device}` : device };
    });
  });
  return { wanted, error: studies.find((study) => study.error)?.error ?? null };
}

function useCurves(wanted: Wanted[], joint: string): { curves: Curve[]; waiting: boolean; error: Error | null } {
  const asked = wanted.flatMap((one, look) => SHOWN.map(([channel, approach]) => ({ ...one, look, channel: `${channel}.${joint}`, approach })));
  return useQueries({
    queries: asked.map(({ job, log, channel }) => ({
      queryKey: ["overlay", job, log, channel],
      staleTime: Infinity,
      retry: false,
      queryFn: async () => {
        const { items } = await whole((query) => answer(api.GET("/api/v1/jobs/{job_id}/series", { params: { path: { job_id: job }, query } })));
        const series = items.find((each) => each.log === log);
        if (!series?.channels.some(({ name }) => name === channel)) return null;
        const query = { channels: [channel], width: 600 };
        return answer(api.GET("/api/v1/jobs/{job_id}/series/{name}/tiles", { params: { path: { job_id: job, name: series.name }, query } }));
      },
    })),
    combine: (found) => ({
      waiting: found.some((each) => each.isFetching),
      error: found.find((each) => each.error)?.error ?? null,
      curves: found.flatMap(({ data }, k) => {
        const one = asked[k];
        const values = one && data?.channels[one.channel];
        return one && data && values ? [{ name: `${one.name}, ${one.approach}`, look: one.look, old: one.approach === "B", t: data.t, ...values }] : [];
      }),
    }),
  });
}
