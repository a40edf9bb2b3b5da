import { Anchor, Button, Group, Select, Stack, Table, Text, Title } from "@mantine/core";
import { useState } from "react";
import { useNavigate, useParams } from "react-router";

import { useFit, useKeepMap, useMaps, useMotion, useRestate, type Motion, type Restated } from "../../api/motions";
import { fileAddress } from "../../api/robots";
import { isActive } from "../../api/studies";
import { DeleteButton } from "../../parts/DeleteButton";
import { FactList } from "../../parts/FactList";
import { FileTable } from "../../parts/FileTable";
import { Loading } from "../../parts/Loading";
import { percent } from "../../parts/digits";
import { PageTitle } from "../../parts/PageTitle";
import { ProblemBox } from "../../parts/ProblemBox";
import { StateBadge } from "../../parts/StateBadge";
import { WideTable, number } from "../../parts/WideTable";
import { AskRobot } from "./AskRobot";
import { CaptureOverTime } from "./OverTime";
import { ContactsEditor } from "./ContactsEditor";
import { Fitted } from "./Fitted";
import { factsOf, partWords, toldWords } from "./facts";
import { PlanList } from "./MotionsPage";

/** One capture: what it is, what was guessed, when its feet stand, and for which robot it is planned. */
export function Component() {
  const { motionId = "" } = useParams();
  const { data: motion, error, refetch } = useMotion(motionId);
  if (error && !motion) return <ProblemBox error={error} retry={() => void refetch()} />;
  if (!motion) return <Loading what="the motion" lines={6} />;
  return (
    <>
      <PageTitle title={motion.name} lead={[...factsOf(motion), `version ${motion.version}`].join(" · ")}>
        <DeleteButton kind="motions" id={motion.id} name={`${motion.name}, version ${motion.version}`}>
          This version goes, with its files and contacts. Plans that are made of it have to be deleted before.
        </DeleteButton>
      </PageTitle>
      <Stack gap="xl">
        <WhatItIs key={motion.id} motion={motion} />
        {motion.summary.holds !== "angles" && <ContactsEditor key={`feet ${motion.id}`} motionId={motion.id} />}
        {motion.summary.holds !== "angles" && <AskRobot motion={motion} />}
        <PlanList title="Planned of it" of={{ motion_id: motion.id }} />
        <CaptureOverTime motion={motion} />
        <section aria-labelledby="handed-in">
          <Title order={2} size="h3" id="handed-in" mb="sm">
            Files handed in
          </Title>
          <FileTable label="Files handed in" files={motion.files ?? []} href={(path) => fileAddress("motions", motion.id, path)} />
        </section>
      </Stack>
    </>
  );
}

function WhatItIs({ motion }: { motion: Motion }) {
  const { told } = motion.summary;
  const facts = Object.entries(told).map(([key, value]): [string, React.ReactNode] => [toldWords(key), String(value)]);
  return (
    <section aria-labelledby="what">
      <Title order={2} size="h3" id="what" mb="xs">
        What it is
      </Title>
      <FactList facts={facts} />
      <Stack gap="md" mt="md">
        <Restate motion={motion} />
        <Labels motion={motion} />
        {motion.summary.holds !== "angles" && <Body motion={motion} />}
      </Stack>
    </section>
  );
}

/** How it is read now, where the file is silent or wrong. */
function statedOf({ capture }: Motion): Restated {
  return { up: capture?.up ?? null, unit: capture?.unit ?? null, angle: capture?.angle ?? null, subject: capture?.subject ?? null };
}

/** Read it otherwise: the same files, another version. */
function Restate({ motion }: { motion: Motion }) {
  const restate = useRestate(motion.id);
  const navigate = useNavigate();
  const { data: maps } = useMaps();
  const capture = motion.capture;
  const [said, say] = useState<Restated>(statedOf(motion));
  const changed = JSON.stringify(said) !== JSON.stringify(statedOf(motion));
  const send = () =>
    restate.mutate({ ...said, ...(said.map ? {} : { names: capture?.names ?? {} }) }, { onSuccess: (now) => void navigate(`/motions/${now.id}`) });
  return (
    <div>
      <Group align="flex-end" gap="sm">
        <Select label="Upwards" data={["x", "y", "z", "-x", "-y", "-z"]} value={said.up ?? null} clearable placeholder="as read" onChange={(up) => say({ ...said, up: up as Restated["up"] })} />
        <Select label="Unit of length" data={["m", "cm", "mm", "in", "cmu"]} value={said.unit ?? null} clearable placeholder="as read" onChange={(unit) => say({ ...said, unit: unit as Restated["unit"] })} />
        <Select label="Unit of angles" data={["deg", "rad"]} value={said.angle ?? null} clearable placeholder="as read" onChange={(angle) => say({ ...said, angle: angle as Restated["angle"] })} />
        {(maps?.items.length ?? 0) > 0 && (
          <Select label="Names" data={maps!.items.map(({ name }) => name)} value={said.map ?? null} clearable placeholder="as they are" onChange={(map) => say({ ...said, map })} />
        )}
        <Button variant="default" disabled={!changed} loading={restate.isPending} onClick={send}>
          Read it so
        </Button>
      </Group>
      <Text size="xs" c="dimmed" mt={4}>
        What was guessed wrong is said here; the same files become the next version.
      </Text>
      {restate.error && <ProblemBox error={restate.error} />}
    </div>
  );
}

const SHOWN = 300;

function Labels({ motion }: { motion: Motion }) {
  const labels = motion.summary.labels ?? [];
  const unknown = labels.filter(({ segment }) => segment === null);
  const [all, showAll] = useState(false);
  const shown = all ? labels : unknown;
  if (motion.summary.holds === "angles") return null;
  return (
    <div>
      <Group gap="sm" mb={4}>
        <Text size="sm">
          {labels.length - unknown.length} of {labels.length} {motion.summary.holds === "markers" ? "markers" : "bones"} are on a known part of the body.
        </Text>
        <Button size="compact-sm" variant="subtle" onClick={() => showAll(!all)}>
          {all ? "Show those of no known part" : "Show all"}
        </Button>
      </Group>
      {shown.length > 0 && (
        <WideTable label="Labels" columns={["Label", "Part of the body", number("not seen in"), "Is called elsewhere"]} mostHeight="18rem">
          {shown.slice(0, SHOWN).map((label) => (
            <Table.Tr key={label.name}>
              <Table.Th scope="row">{label.name}</Table.Th>
              <Table.Td>{label.segment === null ? "not known" : partWords(label.segment)}</Table.Td>
              <Table.Td data-number>{label.gaps > 0 ? percent(label.gaps, 1) : ""}</Table.Td>
              <Table.Td>{Object.entries(motion.capture?.names ?? {}).find(([, known]) => known === label.name)?.[0] ?? ""}</Table.Td>
            </Table.Tr>
          ))}
        </WideTable>
      )}
      {unknown.length > 0 && <NameThem motion={motion} unknown={unknown.map(({ name }) => name)} />}
    </div>
  );
}

/** What own labels are called in a set of names that is known; kept, and taken at once. */
function NameThem({ motion, unknown }: { motion: Motion; unknown: string[] }) {
  const [names, setNames] = useState<Record<string, string>>({});
  const [own, setOwn] = useState<string | null>(null);
  const [known, setKnown] = useState("");
  const [title, setTitle] = useState(`${motion.name}`);
  const keep = useKeepMap();
  const restate = useRestate(motion.id);
  const navigate = useNavigate();
  const save = async () => {
    const kept = await keep.mutateAsync({ name: title.trim(), names: { ...(motion.capture?.names ?? {}), ...names } });
    const now = await restate.mutateAsync({ ...statedOf(motion), map: kept.name });
    void navigate(`/motions/${now.id}`);
  };
  return (
    <details>
      <summary>Say what own names are called</summary>
      <Group align="flex-end" gap="sm" my="xs">
        <Select label="Own name" data={unknown} value={own} onChange={setOwn} searchable />
        <label>
          <Text size="sm" fw={500}>
            Known name
          </Text>
          <input value={known} onChange={(event) => setKnown(event.currentTarget.value)} placeholder="LASI, Hips …" />
        </label>
        <Button
          variant="default"
          disabled={!own || !known.trim()}
          onClick={() => {
            setNames({ ...names, [own!]: known.trim() });
            setOwn(null);
            setKnown("");
          }}
        >
          Add
        </Button>
      </Group>
      {Object.entries(names).map(([from, to]) => (
        <Text key={from} size="sm">
          {from} is {to}{" "}
          <Anchor component="button" size="sm" onClick={() => setNames(Object.fromEntries(Object.entries(names).filter(([each]) => each !== from)))}>
            remove
          </Anchor>
        </Text>
      ))}
      <Group align="flex-end" gap="sm" mt="xs">
        <label>
          <Text size="sm" fw={500}>
            Kept as
          </Text>
          <input value={title} onChange={(event) => setTitle(event.currentTarget.value)} />
        </label>
        <Button disabled={!Object.keys(names).length || !title.trim()} loading={keep.isPending || restate.isPending} onClick={() => void save().catch(() => undefined)}>
          Keep these names and read it so
        </Button>
      </Group>
      {(keep.error ?? restate.error) && <ProblemBox error={keep.error ?? restate.error} />}
    </details>
  );
}

/** The body that fits it, where somebody asks. */
function Body({ motion }: { motion: Motion }) {
  const fit = useFit(motion.id);
  const job = motion.latest_job;
  return (
    <>
    <Group gap="sm">
      {!job || job.state === "failed" || job.state === "cancelled" ? (
        <Button variant="default" loading={fit.isPending} onClick={() => fit.mutate()}>
          Fit a body
        </Button>
      ) : null}
      {job && (
        <>
          <StateBadge state={job.state} />
          <Text size="sm" role="status">
            {isActive(job.state) ? job.message || "A body is fitted." : job.state === "succeeded" ? "A body was fitted: its angles are below." : job.reason}
          </Text>
        </>
      )}
      {fit.error && <ProblemBox error={fit.error} />}
    </Group>
    {job?.state === "succeeded" && <Fitted jobId={job.id} />}
    </>
  );
}
