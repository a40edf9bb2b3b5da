import { Button, Group, NativeSelect, Paper, Stack, Text } from "@mantine/core";
import { useQueryClient } from "@tanstack/react-query";
import { lazy, Suspense } from "react";

import { answer, api } from "../../../api/client";
import { usePlans, type What } from "../../../api/payloads";
import { freePath } from "../../../parts/freePath";
import { Loading } from "../../../parts/Loading";
import { NumberField } from "../../../parts/NumberField";
import { ProblemBox } from "../../../parts/ProblemBox";
import { useDeed } from "../../../parts/useDeed";
import { PlanBox } from "../Plans";
import { AddFiles } from "./AddFiles";
import type { Role } from "./content";
import { saysOf, type Fault } from "./faults";
import { Beside } from "./Fields";
import { LogTable } from "./LogTable";
import { Part } from "./SensorStep";
import type { Drafted } from "./useDraft";

const PayloadView = lazy(() => import("../../../view3d/PayloadView"));

const WORDS = {
  postures: {
    plan: "Postures to hold",
    asked: "Plan postures",
    log: "Your log of postures",
    how: "Stop for a second in 6 to 21 postures; gravity must pull along every axis of the sensor. One log is enough: the stops are found in it.",
  },
  excitation: {
    plan: "A motion that tells the inertia",
    asked: "Plan excitation",
    log: "Your log of the excitation",
    how: "10 s in which the wrist turns about all three axes, fast, and nothing touches the payload. Without it, mass and centre are told but no inertia.",
  },
} as const;
const CHOICES: Record<What, [string, string, number][]> = {
  postures: [
    ["count", "Postures", 21],
    ["hold_s", "Each held for [s]", 1],
  ],
  excitation: [
    ["duration_s", "It lasts [s]", 10],
    ["rate_hz", "Samples per second", 250],
    ["harmonics", "Harmonics", 5],
    ["starts", "Searches from as many starts", 4],
  ],
};

type Props = { drafted: Drafted; what: What; faults: readonly Fault[]; tried: boolean; ready: boolean; kept: (id: string) => void };

/** Plan it, look at it, record it on the robot, and hand the log in. */
export function RecordStep({ drafted, what, faults, tried, ready, kept }: Props) {
  const { draft } = drafted;
  const words = WORDS[what];
  return (
    <Stack gap="xl">
      {draft.content.plan && (
        <Part title={words.plan}>
          <Choices drafted={drafted} what={what} says={saysOf(faults, tried)} />
          <Ask drafted={drafted} what={what} ready={ready} kept={kept} />
          {draft.planned.map((id) => (
            <Planned key={id} id={id} what={what} name={draft.content.name ?? ""} />
          ))}
        </Part>
      )}
      <Part title={words.log}>
        <AddFiles title={`Drop ${words.log.toLowerCase()}`} several take={takeAs(drafted, what)}>
          {words.how}
        </AddFiles>
        <LogTable label={words.log} drafted={drafted} roles={[what]} faults={faults} />
        <Unused drafted={drafted} role={what} />
      </Part>
    </Stack>
  );
}

/** A log under the name of one that is taken already is kept beside it. */
export function takeAs({ add, set, draft }: Drafted, role: Role) {
  return (dropped: { path: string }[], together: boolean) => {
    const taken = draft.content.logs.flatMap(({ file }) => file);
    const files = dropped.map((file) => {
      const path = freePath(file.path, taken);
      taken.push(path);
      return { ...file, path };
    });
    add(files);
    const logs = files.map(({ path }) => path).filter((path) => !/\.(urdf|xml|stl|dae|obj|ply)$/i.test(path));
    const groups = together ? [logs] : logs.map((path) => [path]);
    set((now) => ({
      ...now,
      logs: [
        ...now.logs.filter(({ file }) => !file.some((path) => logs.includes(path))),
        ...groups.filter((file) => file.length > 0).map((file) => ({ file, role })),
      ],
    }));
  };
}

/** Logs that were dropped for their columns' names may be what is asked for here. */
export function Unused({ drafted: { draft, set, look }, role }: { drafted: Drafted; role: Role }) {
  const used = new Set(draft.content.logs.flatMap(({ file }) => file));
  const free = draft.files.filter(({ path }) => !used.has(path) && look?.logs.some(({ file }) => file === path));
  if (free.length === 0) return null;
  return (
    <Group gap="sm">
      {free.map(({ path }) => (
        <Button key={path} variant="default" onClick={() => set((now) => ({ ...now, logs: [...now.logs, { file: [path], role }] }))}>
          Take {path}
        </Button>
      ))}
    </Group>
  );
}

function Choices({ drafted: { draft, set }, what, says }: { drafted: Drafted; what: What; says: (key: string) => string | undefined }) {
  const chosen = draft.content.plan?.[what] ?? {};
  const put = (key: string, value: unknown) => set((now) => (now.plan ? { ...now, plan: { ...now.plan, [what]: { ...now.plan[what], [key]: value } } } : now));
  return (
    <Beside>
      {CHOICES[what].map(([key, label, usual]) => (
        <NumberField key={key} label={label} w="9rem" placeholder={String(usual)} value={chosen[key] as number | undefined} error={says(`plan.${what}.${key}`)} set={(value) => put(key, value)} />
      ))}
      {what === "postures" && (
        <NativeSelect
          label="Chosen by"
          value={(chosen["choice"] as string | undefined) ?? "least_std"}
          data={[
            { value: "least_std", label: "smallest standard deviations" },
            { value: "algorithm_1", label: "Algorithm 1 of the paper" },
          ]}
          onChange={(event) => put("choice", event.currentTarget.value)}
        />
      )}
    </Beside>
  );
}

/** A plan is made of what is stored: the draft is kept first. */
function Ask({ drafted, what, ready, kept }: Pick<Props, "drafted" | "what" | "ready" | "kept">) {
  const { start, busy, error } = useDeed();
  const cache = useQueryClient();
  const ask = async () => {
    const id = await drafted.keep();
    drafted.planned(id);
    kept(id);
    await answer(api.POST("/api/v1/payloads/{payload_id}/plans", { params: { path: { payload_id: id } }, body: { what } }));
    await cache.invalidateQueries({ queryKey: ["payloads", id, "plans"] });
  };
  return (
    <>
      <Group gap="sm">
        <Button variant="default" disabled={!ready} loading={busy} onClick={() => start(ask)}>
          {WORDS[what].asked}
        </Button>
        <Text size="sm" c="dimmed">
          {ready ? "What is written so far is kept as a version of the payload." : "First say what is missing in the steps before."}
        </Text>
      </Group>
      {error !== null && <ProblemBox error={error} />}
    </>
  );
}

/** The newest plan of one version, on its robot. */
function Planned({ id, what, name }: { id: string; what: What; name: string }) {
  const { data: plans } = usePlans(id);
  const plan = plans?.find(({ job }) => job.settings["what"] === what);
  if (!plan) return null;
  return (
    <>
      <PlanBox plan={plan} />
      {what === "postures" && plan.found && (
        <Paper withBorder p="sm">
          <Suspense fallback={<Loading what="the 3D view" />}>
            <PayloadView payloadId={id} name={name} about={plan.job.id} />
          </Suspense>
        </Paper>
      )}
    </>
  );
}
