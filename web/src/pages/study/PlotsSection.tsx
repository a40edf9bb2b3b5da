import { Alert, Button, CopyButton, Group, Select, Stack, Switch, Text, Title } from "@mantine/core";
import { IconLink } from "@tabler/icons-react";
import { lazy, Suspense, useMemo } from "react";

import type { Study } from "../../api/studies";
import { Loading } from "../../parts/Loading";
import { ProblemBox } from "../../parts/ProblemBox";
import { Cursor } from "../../plots/cursor";
import { PlotStack } from "../../plots/PlotStack";
import { useSeries, type SeriesFacts, type Source } from "../../plots/series";
import { useView } from "../../plots/view";
import type { Job } from "./jobs";
import styles from "./PlotsSection.module.css";
import { useArtifacts, type Results } from "./results";
import { factsOf, optionsOf } from "./logFacts";
import { summaryOf, type StudyLog } from "./summary";

const RobotView = lazy(() => import("../../view3d/RobotView").then((module) => ({ default: module.RobotView })));

type Props = { study: Study; job: Job; results: Results };

/** One log at a time: what was measured, what each model says, what the wear gives. */
export default function PlotsSection({ study, job, results }: Props) {
  const [view, change] = useView();
  const logs = summaryOf(study).logs ?? [];
  const files = useArtifacts(job.id, job.state === "succeeded");
  const names = useMemo(() => seriesNames(files.data?.items ?? []), [files.data]);
  const name = view.log !== null && names.includes(view.log) ? view.log : firstOf(names, logs, results);
  const source: Source = { of: "jobs", id: job.id };
  const { data: series, error, refetch } = useSeries(source, name);
  const cursor = useMemo(() => new Cursor(view.at), [name]);
  const first = useMemo(() => (series ? plotsFor(series, results) : []), [series, results]);

  const failure = files.error ?? error;
  if (failure) return <ProblemBox error={failure} retry={() => void (files.error ? files.refetch() : refetch())} />;
  if (!files.data) return <Loading what="the series" />;
  if (name === undefined) return <Alert color="gray" variant="outline" title="This job made no series" />;
  return (
    <Stack gap="md">
      <Group justify="space-between" align="flex-end" gap="sm">
        <Title order={2} size="h3">
          Over time
        </Title>
        <Group gap="sm">
          <Switch
            size="sm"
            label="Robot in 3D"
            checked={view.robot}
            onChange={(event) => change({ robot: event.currentTarget.checked })}
          />
          <CopyButton value={window.location.href} timeout={1500}>
            {({ copied, copy }) => (
              <Button size="xs" variant="default" leftSection={<IconLink size={16} aria-hidden />} onClick={copy}>
                {copied ? "Copied" : "Copy link to this view"}
              </Button>
            )}
          </CopyButton>
        </Group>
      </Group>
      {view.log !== null && view.log !== name && (
        <Alert color="yellow" variant="outline" title={`This job has no series “${view.log}”`}>
          Shown instead: {name}.
        </Alert>
      )}
      <Select
        label="Log"
        description={series ? factsOf(series, logs) : "reading …"}
        maw={560}
        searchable
        allowDeselect={false}
        data={optionsOf(names, logs)}
        value={name}
        onChange={(log) => log && log !== name && change({ log, from: null, to: null, at: null })}
      />
      <div className={styles.sides} data-robot={view.robot || undefined}>
        {view.robot && (
          <div className={styles.robot}>
            <Suspense fallback={<Loading what="the 3D view" />}>
              <RobotView key={`${job.id} ${name}`} jobId={job.id} log={name} cursor={cursor} />
            </Suspense>
          </div>
        )}
        {series ? (
          <PlotStack key={name} source={source} series={series} view={view} first={first} cursor={cursor} onView={change} />
        ) : (
          <Loading what="the series" />
        )}
      </div>
      {results.reading && series?.channels.some((each) => /^support_._low\./.test(each.name)) && (
        <Text size="sm" c="dimmed">
          {results.reading.support_interval}
        </Text>
      )}
    </Stack>
  );
}

/** `series/bend_1.parquet` -> `bend_1`. */
function seriesNames(files: { name: string }[]): string[] {
  return files.flatMap(({ name }) => /^series\/([^/]+)\.parquet$/.exec(name)?.[1] ?? []);
}

/** Logs with the device first: they have most to show. */
function firstOf(names: string[], logs: StudyLog[], results: Results): string | undefined {
  const worn = results.support.find((each) => each.main)?.logs[0];
  const heldOut = logs.find((log) => log.role !== "identification")?.name;
  return [worn, heldOut].find((each) => each !== undefined && names.includes(each)) ?? names[0];
}

/** What a reader most likely wants first: the joints that the wear acts on, else those that were in question, else the
 * first joints. */
function plotsFor(series: SeriesFacts, results: Results): string[] {
  const worn = results.support.filter((each) => each.main && each.logs.includes(series.name)).map((each) => each.joint);
  const named = (results.discrepancy?.findings ?? []).map((each) => each.held_out.channel);
  const trunk = results.identification.summary.find((each) => each.kind === "trunk_torque")?.channels ?? [];
  if (worn.length) return [`support.${worn[0]}`, `tau.${worn[0]}`, "tension"];
  const measured = series.channels.flatMap(({ name }) => (name.startsWith("measured.") ? [name.slice(9)] : []));
  const joints = measured.filter((each) => each.startsWith("tau."));
  return [...new Set([...named, ...trunk, "base.my", ...joints])].filter((each) => measured.includes(each)).slice(0, 3);
}
