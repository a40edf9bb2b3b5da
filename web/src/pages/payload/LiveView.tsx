import { Alert, Group, List, NativeSelect, Paper, SimpleGrid, Stack, Table, Text, Title } from "@mantine/core";
import { useMemo, useState, type ReactNode } from "react";

import { useWatched, type Alarm, type Course, type LiveStream, type Watched } from "../../api/live";
import { fixed, isNumber, NONE, plusMinus, significant } from "../../parts/digits";
import { FactList } from "../../parts/FactList";
import { Said } from "../../parts/Said";
import { TimePlot } from "../../parts/TimePlot";
import { Uncertain } from "../../parts/Uncertain";
import { When } from "../../parts/When";
import { number, WideTable } from "../../parts/WideTable";
import { ForceArrow } from "./ForceArrow";
import { NAMES } from "./ValueTable";

const AXES = ["x", "y", "z"];
const STATES: Record<string, string> = {
  static: "static: only what the postures say",
  converging: "converging: motion adds to it",
  converged: "converged: no number moves any more",
  frozen: "frozen: nothing excites, or something touches",
};
const Z95 = 1.959964;
const LOST = ["missing", "doubled", "out_of_order", "refused"];

/** A stream that runs: the contact wrench of the last 20 s, alarms, and what is known of the payload by now. */
export function LiveView({ stream }: { stream: LiveStream }) {
  const seen = useWatched(stream.payload_id, stream.id);
  const marks = useMemo(() => seen.alarms.filter(({ to }) => to >= (seen.t[0] ?? Infinity)).map(({ from, to }) => ({ from: Math.max(from, seen.t[0]!), to })), [seen]);
  const [force, moment] = useMemo(
    () => [0, 3].map((first) => AXES.map((axis, k) => ({ name: `${first ? "τ" : "f"}_${axis}`, values: seen.wrench[first + k]!, look: k }))),
    [seen],
  );
  const touched = seen.alarms.at(-1)?.lasts === true;
  return (
    <Paper withBorder p="md" component="article" aria-label="Running stream" data-live={stream.id}>
      <Title order={3} size="h4" mb="xs">
        Running since <When at={stream.started_at} />
      </Title>
      <Stack gap="md">
        {seen.line === "opening" && <Text size="sm">Waiting for the first answer of the stream.</Text>}
        {seen.line === "closed" && <Text size="sm">The line is closed: what is shown is old. It is tried again every 3 s.</Text>}
        {seen.payload && seen.payload.in_doubt.length > 0 && <InDoubt why={seen.payload.in_doubt} />}
        <Group align="flex-start" gap="xl" wrap="wrap">
          <div style={{ flex: "1 1 20rem" }}>
            <FactList facts={factsOf(seen, touched)} />
          </div>
          <Arrow seen={seen} touched={touched} />
        </Group>
        {seen.t.length > 0 && (
          <SimpleGrid cols={{ base: 1, md: 2 }}>
            <TimePlot label="Contact force of the last 20 s; alarms are marked" unit="N" t={seen.t} lines={force!} marks={marks} />
            <TimePlot label="Contact moment of the last 20 s; alarms are marked" unit="N·m" t={seen.t} lines={moment!} marks={marks} />
          </SimpleGrid>
        )}
        {seen.alarms.length > 0 && <Alarms alarms={seen.alarms} />}
        {seen.course.t.length > 1 && <Converging course={seen.course} />}
        {seen.payload && <Known seen={seen} />}
      </Stack>
    </Paper>
  );
}

/** Why the numbers below are not to be believed. */
function InDoubt({ why }: { why: string[] }) {
  return (
    <Alert color="orange" variant="default" title="Not to be believed">
      <List size="sm">
        {why.map((words) => (
          <List.Item key={words}>
            <Said words={words} />
          </List.Item>
        ))}
      </List>
    </Alert>
  );
}

/** As long as the largest alarm of those that are shown, or five times what counts as contact. */
function Arrow({ seen, touched }: { seen: Watched; touched: boolean }) {
  const force = forceOf(seen);
  const largest = Math.max(...seen.alarms.filter(({ to }) => to >= (seen.t[0] ?? Infinity)).map((alarm) => Math.hypot(...alarm.force)), 0);
  const full = Math.max(largest, 5 * (seen.payload?.threshold_n ?? 0), force ? Math.hypot(...force) : 0);
  return (
    <figure style={{ margin: 0 }}>
      <ForceArrow force={force} full={full} touched={touched} label="Contact force as an arrow in the sensor’s axes" />
      <Text component="figcaption" size="xs" c="dimmed">
        Contact force in the sensor’s axes; full length {significant(full)} N
      </Text>
    </figure>
  );
}

function forceOf(seen: Watched): number[] | null {
  const now = seen.wrench.slice(0, 3).map((trace) => trace.at(-1));
  return now.every(isNumber) ? (now as number[]) : null;
}

/** One number of Φ since watching began, with its 95 % interval. */
function Converging({ course }: { course: Course }) {
  const [name, choose] = useState("m");
  const lines = useMemo(() => {
    const [value, std] = [course.value, course.std].map((each) => each.map((all) => all[name] ?? null));
    const bound = (side: number) => value!.map((each, k) => (each === null ? null : each + side * Z95 * (std![k] ?? 0)));
    return [
      { name: NAMES[name] ?? name, values: value!, look: 0 },
      { name: "95 % from", values: bound(-1), look: 6, old: true },
      { name: "95 % to", values: bound(1), look: 6, old: true },
    ];
  }, [course, name]);
  const data = Object.keys(course.value[0] ?? {}).map((each) => ({ value: each, label: NAMES[each] ?? each }));
  return (
    <div>
      <NativeSelect label="Course of" data={data} value={name} onChange={(event) => choose(event.currentTarget.value)} w="14rem" mb="xs" />
      <TimePlot label={`${NAMES[name] ?? name} since watching began, with its 95 % interval`} unit={unitOf(name)} t={course.t} lines={lines} height={200} />
    </div>
  );
}

function factsOf({ payload, missed, error, ...seen }: Watched, touched: boolean): [string, ReactNode][] {
  const force = forceOf({ payload, missed, error, ...seen });
  const size = force && Math.hypot(...force);
  const facts: [string, ReactNode][] = [
    ["Alarm", touched ? "something touches" : "none"],
    ["Contact force [N]", force ? force.map((value, k) => `${AXES[k]} ${plusMinus(value, seen.std[k])}`).join(", ") : NONE],
    ["Size and direction", touched && force && size ? `${significant(size)} N towards (${force.map((value) => fixed(value / size, 2)).join(", ")})` : "no more than chance"],
  ];
  if (payload) {
    const { counts } = payload;
    facts.push(
      ["State", STATES[payload.state] ?? payload.state],
      ["Counts as contact from", `${significant(payload.threshold_n)} N`],
      ["μ", plusMinus(payload.mu, payload.mu_std)],
      ...(payload.late_ms === null ? [] : [["Wrench late by [ms]", plusMinus(payload.late_ms, payload.late_std_ms)] as [string, string]]),
      ...(payload.calibration ? [["± holds the sensor’s calibration", <Said key="calibration" words={payload.calibration} />] as [string, ReactNode]] : []),
      ["Samples", `${counts["taken"]} taken, ${LOST.reduce((sum, name) => sum + (counts[name] ?? 0), 0)} dropped, ${counts["late"]} late`],
    );
  }
  if (missed) facts.push(["Not shown", `${missed} answers came faster than this page took them`]);
  if (error) facts.push(["Last fault", error]);
  return facts;
}

function Alarms({ alarms }: { alarms: Alarm[] }) {
  return (
    <WideTable label="Alarms" mostHeight="14rem" columns={[number("From", "s"), number("To", "s"), number("f_x", "N"), number("f_y", "N"), number("f_z", "N"), number("largest |f|", "N")]}>
      {[...alarms].reverse().map(({ from, to, lasts, force }) => (
        <Table.Tr key={from} data-alarm={lasts ? "lasts" : "over"}>
          <Table.Td data-number>{fixed(from, 2)}</Table.Td>
          <Table.Td data-number>{lasts ? "lasts" : fixed(to, 2)}</Table.Td>
          {[...force, Math.hypot(...force)].map((value, k) => (
            <Table.Td key={k} data-number>
              {significant(value)}
            </Table.Td>
          ))}
        </Table.Tr>
      ))}
    </WideTable>
  );
}

/** Φ and the sensor's zero, with what they were when watching began: standard deviations shrink. */
function Known({ seen: { payload, first } }: { seen: Watched }) {
  if (!payload || !first) return null;
  return (
    <WideTable label="Known by now" mostHeight="20rem" columns={["Quantity", number("Now ± std"), number("std when watching began"), number("std now"), "Remark"]}>
      {Object.entries(payload.value).map(([name, value]) => (
        <Table.Tr key={name} data-known={name}>
          <Table.Th scope="row">{NAMES[name] ?? name}</Table.Th>
          <Table.Td data-number>
            <Uncertain value={value} std={payload.std[name]} unit={unitOf(name)} />
          </Table.Td>
          <Table.Td data-number>{significant(first.std[name], 2)}</Table.Td>
          <Table.Td data-number>{significant(payload.std[name], 2)}</Table.Td>
          <Table.Td>{payload.decided.includes(name) ? "" : "not decided"}</Table.Td>
        </Table.Tr>
      ))}
    </WideTable>
  );
}

function unitOf(name: string): string {
  if (name.endsWith("0")) return name.startsWith("f") ? "N" : "N·m";
  return name === "m" ? "kg" : name.startsWith("I") ? "kg·m²" : "kg·m";
}
