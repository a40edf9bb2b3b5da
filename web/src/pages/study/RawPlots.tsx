import { Select, Stack } from "@mantine/core";
import { useMemo } from "react";

import type { Study } from "../../api/studies";
import { Loading } from "../../parts/Loading";
import { ProblemBox } from "../../parts/ProblemBox";
import { Cursor } from "../../plots/cursor";
import { PlotStack } from "../../plots/PlotStack";
import { useSeries, type Source } from "../../plots/series";
import type { View } from "../../plots/view";
import { factsOf, optionsOf } from "./logFacts";
import { summaryOf } from "./summary";

const FIRST = 3; // plots

type Props = { study: Study; log: string; view: View; change: (wanted: Partial<View>) => void };

/** One log of the study as it was read, over time. */
export default function RawPlots({ study, log, view, change }: Props) {
  const logs = summaryOf(study).logs ?? [];
  const source: Source = { of: "studies", id: study.id };
  const { data: series, error, refetch } = useSeries(source, log);
  const cursor = useMemo(() => new Cursor(view.at), [log]);
  const first = useMemo(() => firstOf(series?.channels.map((each) => each.name) ?? []), [series]);
  return (
    <Stack gap="md">
      <Select
        label="Log to plot"
        description={series ? factsOf(series, logs) : error ? "" : "reading …"}
        maw={560}
        searchable
        allowDeselect={false}
        data={optionsOf(logs.map(({ name }) => name), logs)}
        value={log}
        onChange={(wanted) => wanted && wanted !== log && change({ log: wanted, from: null, to: null, at: null })}
      />
      {error && <ProblemBox error={error} retry={() => void refetch()} />}
      {!series && !error && <Loading what="the log" />}
      {series && <PlotStack key={log} source={source} series={series} view={view} first={first} cursor={cursor} onView={change} />}
    </Stack>
  );
}

/** Positions, then what drives: what tells soonest whether a log is sound. */
function firstOf(channels: string[]): string[] {
  const of = (kind: string) => channels.filter((name) => name.startsWith(`${kind}.`));
  const driven = [...of("tau"), ...of("i")];
  return [...of("q").slice(0, 1), ...driven.slice(0, 1), ...of("q").slice(1), ...driven.slice(1)].slice(0, FIRST);
}
