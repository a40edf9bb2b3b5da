import { Anchor, Badge, Group, NativeSelect, Paper, SimpleGrid, Stack, Table, Text, Title } from "@mantine/core";
import { useDebouncedValue } from "@mantine/hooks";
import { useMemo, useState } from "react";
import { Link } from "react-router";

import type { Robot } from "../../api/robots";
import { useEveryStudy, type Study } from "../../api/studies";
import { useWhatIf, type Change, type WhatIf as Answer } from "../../api/whatIf";
import { Loading } from "../../parts/Loading";
import { fixed, NONE } from "../../parts/digits";
import { ProblemBox } from "../../parts/ProblemBox";
import { TimePlot, type TimeLine } from "../../parts/TimePlot";
import { number, WideTable } from "../../parts/WideTable";
import { groupOf, stiffnessOf, type DeviceContent } from "./deviceFile";

const PAUSE_MS = 120;

type Log = { name: string; role: string; motion: string | null };
type Props = { robot: Robot; device: DeviceContent; hindered: boolean };

/** What the device as it stands now would do over a recorded motion, beside what the log's own device does. */
export function WhatIf({ robot, device, hindered }: Props) {
  const { studies, isPending, hasNextPage, error, refetch } = useEveryStudy({ robot_id: robot.id });
  const [chosen, choose] = useState("");
  const [chosenLog, chooseLog] = useState("");
  const study = studies.find((each) => each.id === chosen) ?? studies.find((each) => wornLogs(each).length > 0) ?? studies[0];
  const logs = study ? wornLogs(study) : [];
  const log = logs.find((each) => each.name === chosenLog) ?? logs[0];
  return (
    <Paper withBorder p="md" component="section" aria-labelledby="what-if">
      <Title order={3} size="h4" id="what-if" mb="xs">
        What it would do
      </Title>
      {error && !study ? (
        <ProblemBox error={error} retry={() => void refetch()} />
      ) : isPending || (!log && hasNextPage) ? (
        <Loading what="the studies with this robot" lines={3} />
      ) : !study || !log ? (
        <Text size="sm">
          {study ? `The study ${study.name} holds no log with a device worn.` : "There is no study with the files of this very robot yet."} Hand one in
          at <Anchor component={Link} to="/studies" underline="always">the studies</Anchor>, and the torque over its motions is drawn here.
        </Text>
      ) : (
        <Stack gap="sm">
          <SimpleGrid cols={{ base: 1, xs: 2 }} spacing="sm">
            <NativeSelect
              label="Study"
              value={study.id}
              onChange={(event) => choose(event.currentTarget.value)}
              data={studies.map((each) => ({ value: each.id, label: each.name }))}
            />
            <NativeSelect
              label="Recorded motion"
              value={log.name}
              onChange={(event) => chooseLog(event.currentTarget.value)}
              data={logs.map((each) => ({ value: each.name, label: each.motion ? `${each.name} (${each.motion})` : each.name }))}
            />
          </SimpleGrid>
          <Predicted studyId={study.id} log={log.name} device={device} hindered={hindered} />
        </Stack>
      )}
    </Paper>
  );
}

function Predicted({ studyId, log, device, hindered }: { studyId: string; log: string; device: DeviceContent; hindered: boolean }) {
  const [settled] = useDebouncedValue(device, PAUSE_MS);
  const changes = useMemo(() => replaced(settled), [settled]);
  const asked = useWhatIf(studyId, hindered ? undefined : log, changes);
  const [chosen, choose] = useState("");
  const answer = asked.data;
  const joint = answer?.joints.find((each) => each.joint === chosen)?.joint ?? answer?.main[0];
  if (asked.error && !asked.isFetching) return <ProblemBox error={asked.error} />;
  if (!answer) return asked.isFetching ? <Loading what="the log; the first question about it takes a second or more" lines={3} /> : null;
  if (joint === undefined) return <Text size="sm">No joint feels this device over the motion.</Text>;
  return (
    <Stack gap="sm">
      <Group justify="space-between" align="flex-end">
        <NativeSelect
          label="Joint"
          value={joint}
          onChange={(event) => choose(event.currentTarget.value)}
          data={answer.joints.map((each) => ({ value: each.joint, label: answer.main.includes(each.joint) ? `${each.joint} (main)` : each.joint }))}
        />
        <Badge variant="default" tt="none" data-testid="elapsed">
          {asked.isFetching ? "asking …" : `answered in ${fixed(answer.elapsed_ms, 0)} ms`}
        </Badge>
      </Group>
      <Curve answer={answer} joint={joint} />
      <Figures answer={answer} joint={joint} choose={choose} />
      {answer.notes.map((note) => (
        <Text size="sm" key={note}>
          {note}
        </Text>
      ))}
      <Text size="sm" c="dimmed">
        Torque of the bands by their model over {fixed(answer.duration_s, 1)} s, {answer.samples} of {answer.of_samples} samples,
        before: {answer.device.name} as in {answer.device.file} of the study; now: the device as it stands here.
      </Text>
    </Stack>
  );
}

function Curve({ answer, joint }: { answer: Answer; joint: string }) {
  const series = answer.series?.joints[joint];
  const unit = answer.joints.find((each) => each.joint === joint)?.unit ?? "N·m";
  const lines = useMemo<TimeLine[]>(
    () => [
      { name: "before", values: series?.before ?? [], look: 6, old: true },
      { name: "now", values: series?.after ?? [], look: 0 },
    ],
    [series],
  );
  if (!answer.series) return null;
  return <TimePlot label={`Torque on ${joint} over time, before and now`} unit={unit} t={answer.series.t} lines={lines} />;
}

function Figures({ answer, joint, choose }: { answer: Answer; joint: string; choose: (joint: string) => void }) {
  return (
    <WideTable
      label="Torque by joint"
      mostHeight="18rem"
      columns={[
        "Joint",
        number("Peak before", "N·m"),
        number("Peak now", "N·m"),
        number("Mean now", "N·m"),
        number("Change of RMS"),
      ]}
    >
      {answer.joints.map((each) => (
        <Table.Tr key={each.joint} aria-current={each.joint === joint || undefined} onClick={() => choose(each.joint)}>
          <Table.Th scope="row">{each.joint}</Table.Th>
          <Table.Td data-number>{fixed(each.before.peak, 2)}</Table.Td>
          <Table.Td data-number>{fixed(each.after.peak, 2)}</Table.Td>
          <Table.Td data-number>{fixed(each.after.mean, 2)}</Table.Td>
          <Table.Td data-number>{percent(each.percent.rms)}</Table.Td>
        </Table.Tr>
      ))}
    </WideTable>
  );
}

function percent(value: number | null): string {
  if (value === null) return NONE;
  return `${value > 0.05 ? "+" : ""}${fixed(value, 1)} %`;
}

/** The whole device anew: nothing of the log's own stays. */
function replaced(device: DeviceContent): Change[] {
  const bands = device.bands.map((band) => ({
    name: band.name,
    group: groupOf(band),
    via_points: band.via_points,
    law: band.law ?? "linear",
    law_values: band.law_values ?? {},
    ground_truth: false,
    stiffness_n_per_m: stiffnessOf(device, groupOf(band)) ?? null,
    natural_length_m: band.natural_length_m ?? null,
  }));
  return [{ change: "remove_band", of: "*" }, ...bands.map((band) => ({ change: "add_band" as const, band }))] as Change[];
}

function wornLogs(study: Study): Log[] {
  const logs = ((study.summary as { logs?: Log[] }).logs ?? []).filter((log) => log.role === "with_device");
  return logs;
}
