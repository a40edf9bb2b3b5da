import { Anchor, Button, Code, ScrollArea, Stack, Table, Title } from "@mantine/core";

import { lazy, memo, Suspense } from "react";

import { isActive, type Study } from "../../api/studies";
import { address } from "../../app/base";
import { figure, NONE, significant } from "../../parts/digits";
import { Loading } from "../../parts/Loading";
import { sizeOf } from "../../parts/size";
import { When } from "../../parts/When";
import { FactList } from "../../parts/FactList";
import { numbers, WideTable } from "../../parts/WideTable";
import { useView } from "../../plots/view";
import { SignalDoubts } from "./SignalDoubts";
import type { Job } from "./jobs";
import { Pipeline } from "./Pipeline";
import type { Results } from "./results";
import styles from "./RunSection.module.css";
import { phrase, stagesOf } from "./stages";
import { ROLES, summaryOf } from "./summary";
import { capital, KINDS } from "./words";

const RawPlots = lazy(() => import("./RawPlots"));

type Props = { study: Study; job: Job | null; results?: Results };

/** How it was done, from what, and what was said on the way. Raw logs stay in reach whatever became of the job. */
export function RunSection({ study, job, results }: Props) {
  const summary = summaryOf(study);
  return (
    <Stack gap="xl">
      {job && (
        <section aria-labelledby="steps">
          <Title order={2} size="h3" id="steps" mb="sm">
            Steps
          </Title>
          <Pipeline stages={stagesOf(job, summary)} />
        </section>
      )}
      {job && <Said job={job} />}
      {results && <SignalDoubts found={results.doctor} />}
      <section aria-labelledby="logs">
        <Title order={2} size="h3" id="logs" mb="sm">
          Logs
        </Title>
        <Logs study={study} />
        <RawLogs study={study} />
      </section>
      {job && <Facts study={study} job={job} results={results} />}
    </Stack>
  );
}

/** Newest first: what it does now stands on top. */
function Said({ job }: { job: Job }) {
  const steps = [...(job.steps ?? [])].reverse();
  if (!steps.length && !job.log) return null;
  return (
    <section aria-labelledby="log">
      <Title order={2} size="h3" id="log" mb="sm">
        What the job did
      </Title>
      <ScrollArea.Autosize mah={320} type="auto" viewportProps={{ tabIndex: 0, role: "region", "aria-label": "Log of the job" }}>
        {job.log && <Code block className={styles.log}>{job.log}</Code>}
        <ul className={styles.said}>
          {steps.map(({ started_at, message, stage, seconds }, k) => (
            <li key={k}>
              <time dateTime={started_at}>{new Date(started_at).toLocaleTimeString()}</time>
              <span>{capital(phrase({ stage, message }))}</span>
              <span>{seconds === null ? (isActive(job.state) ? "now" : "") : `${significant(seconds, 2)} s`}</span>
            </li>
          ))}
        </ul>
      </ScrollArea.Autosize>
    </section>
  );
}

const Logs = memo(function Logs({ study }: { study: Study }) {
  const { logs = [], devices = [] } = summaryOf(study);
  const worn = new Map(devices.map((each) => [each.file, each.name]));
  const hashes = new Map(study.files?.map((file) => [file.path, file]));
  return (
    <WideTable
      label="Logs of the study"
      columns={["Log", "Role", "Motion", "Worn", ...numbers("Duration", "Rate", "Samples"), "File as handed in"]}
    >
      {logs.map((log) => (
        <Table.Tr key={log.name}>
          <Table.Th scope="row">{log.name}</Table.Th>
          <Table.Td>{ROLES[log.role] ?? log.role}</Table.Td>
          <Table.Td>{log.motion ?? NONE}</Table.Td>
          <Table.Td miw={log.device ? "9rem" : undefined}>{log.device ? (worn.get(log.device) ?? log.device) : NONE}</Table.Td>
          <Table.Td data-number>{figure(log.duration_s)} s</Table.Td>
          <Table.Td data-number>{figure(log.rate_hz)} Hz</Table.Td>
          <Table.Td data-number>{log.samples.toLocaleString("en").replaceAll(",", "\u202f")}</Table.Td>
          <Table.Td>
            {log.file.map((path) => (
              <Anchor key={path} size="sm" href={address(`api/v1/studies/${study.id}/files/${path}`)} download>
                {path}
                {hashes.get(path) && ` (${sizeOf(hashes.get(path)!.size)})`}
              </Anchor>
            ))}
          </Table.Td>
        </Table.Tr>
      ))}
    </WideTable>
  );
});

/** Plots of the logs, whatever became of the job; each is read when it is first asked for. */
function RawLogs({ study }: { study: Study }) {
  const [view, change] = useView("raw_");
  const names = (summaryOf(study).logs ?? []).map((log) => log.name);
  if (names.length === 0) return null;
  if (view.log === null || !names.includes(view.log)) {
    return (
      <Button mt="sm" variant="default" onClick={() => change({ log: names[0] ?? null })}>
        Plot the logs as they were read
      </Button>
    );
  }
  return (
    <section aria-labelledby="raw" style={{ marginTop: "var(--mantine-spacing-xl)" }}>
      <Title order={2} size="h3" id="raw" mb="sm">
        Logs as they were read
      </Title>
      <Suspense fallback={<Loading what="the plots" />}>
        <RawPlots study={study} log={view.log} view={view} change={change} />
      </Suspense>
    </section>
  );
}

function Facts({ study, job, results }: Required<Omit<Props, "results" | "job">> & { job: Job; results?: Results }) {
  const settings = Object.entries(results?.settings ?? job.settings).filter(([, value]) => value !== null);
  const facts: [string, React.ReactNode][] = [
    ["Job", <Code key="c">{job.id}</Code>],
    ["Asked for", <>{KINDS[job.kind] ?? job.kind}, <When at={job.created_at} /></>],
    ["Study", <Code key="c">{study.content_hash.slice(0, 16)}…</Code>],
    ["Code", <Code key="c">{job.code_version ?? "no worker has taken it yet"}</Code>],
    ["Settings", settings.length ? settings.map(([key, value]) => `${key}: ${Array.isArray(value) ? value.join(", ") : String(value)}`).join("; ") : "none"],
  ];
  if (job.code_version && job.code_version !== job.requested_code_version)
    facts.push(["Asked of other code", <Code key="c">{job.requested_code_version}</Code>]);
  if (results) facts.push(["Software", Object.entries(results.software).map((each) => each.join(" ")).join(", ")]);
  return (
    <section aria-labelledby="made">
      <Title order={2} size="h3" id="made" mb="sm">
        How it was made
      </Title>
      <FactList facts={facts} />
    </section>
  );
}
