import { Button, Code, Group, List, Paper, Select, Stack, Text, TextInput, Title } from "@mantine/core";
import { useState } from "react";
import { useNavigate } from "react-router";

import { useAddMotion, useMaps } from "../../api/motions";
import { DropFiles, type Dropped } from "../../parts/DropFiles";
import { ProblemBox } from "../../parts/ProblemBox";

const AXES = ["x", "y", "z", "-x", "-y", "-z"];
const UNITS = ["m", "cm", "mm", "in", "cmu"];
const ANGLES = ["deg", "rad"];
const CAPTURE = /\.(c3d|trc|tsv|csv|mvnx|mot|sto|bvh|amc)$/i;

type Said = { name: string; up: string | null; unit: string | null; angle: string | null; static: string | null; map: string | null };
const NOTHING: Said = { name: "", up: null, unit: null, angle: null, static: null, map: null };

/** Drop a capture; what the file is silent about is asked for, and may be said at once. */
export function HandInMotion() {
  const add = useAddMotion();
  const navigate = useNavigate();
  const [files, setFiles] = useState<Dropped | null>(null);
  const [said, say] = useState<Said>(NOTHING);
  const take = (dropped: Dropped) => {
    const guess = guessStatic([...dropped.keys()]);
    const wanted = { ...NOTHING, static: guess };
    setFiles(dropped);
    say(wanted);
    send(dropped, wanted);
  };
  const send = (dropped: Dropped, wanted: Said) => {
    const fields = Object.fromEntries(Object.entries(wanted).filter(([, value]) => value)) as Record<string, string>;
    add.mutate({ files: dropped, said: fields }, { onSuccess: (motion) => void navigate(`/motions/${motion.id}`) });
  };
  return (
    <Stack gap="sm">
      <DropFiles title="Hand in a capture" choose="Choose files" take={take} busy={add.isPending}>
        Drop one capture: <Code>.c3d</Code>, <Code>.trc</Code>, <Code>.tsv</Code> of Qualisys or <Code>.csv</Code> of Motive or Nexus with markers;{" "}
        <Code>.bvh</Code>, <Code>.mvnx</Code> or <Code>.amc</Code> with its <Code>.asf</Code> of a skeleton; of markers a static trial may come along.
      </DropFiles>
      {add.error && files && (
        <>
          <ProblemBox error={add.error} />
          <Ask files={files} said={said} say={say} busy={add.isPending} send={() => send(files, said)} />
        </>
      )}
    </Stack>
  );
}

function Ask({ files, said, say, busy, send }: { files: Dropped; said: Said; say: (said: Said) => void; busy: boolean; send: () => void }) {
  const { data: maps } = useMaps();
  const captures = [...files.keys()].filter((path) => CAPTURE.test(path));
  return (
    <Paper withBorder p="md" component="section" aria-labelledby="ask-capture">
      <Title order={3} size="h4" id="ask-capture" mb="xs">
        Say what the file does not
      </Title>
      <List size="sm" mb="sm">
        {[...files.keys()].map((path) => (
          <List.Item key={path}>{path}</List.Item>
        ))}
      </List>
      <Group align="flex-end" gap="sm">
        <TextInput label="Name" value={said.name} onChange={(event) => say({ ...said, name: event.currentTarget.value })} />
        <Select label="Upwards" data={AXES} value={said.up} clearable placeholder="as the file says" onChange={(up) => say({ ...said, up })} />
        <Select label="Unit of length" data={UNITS} value={said.unit} clearable placeholder="as the file says" onChange={(unit) => say({ ...said, unit })} />
        <Select label="Unit of angles" data={ANGLES} value={said.angle} clearable placeholder="as the file says" onChange={(angle) => say({ ...said, angle })} />
        {captures.length > 1 && (
          <Select label="Static trial" data={captures} value={said.static} clearable placeholder="none" onChange={(trial) => say({ ...said, static: trial })} />
        )}
        {(maps?.items.length ?? 0) > 0 && (
          <Select label="Names" data={maps!.items.map(({ name }) => name)} value={said.map} clearable placeholder="as they are" onChange={(map) => say({ ...said, map })} />
        )}
        <Button loading={busy} onClick={send}>
          Try again
        </Button>
      </Group>
      <Text size="xs" c="dimmed" mt="xs">
        What is said here is kept with the motion, as motion.yaml.
      </Text>
    </Paper>
  );
}

/** The one of two captures whose name says that nobody moves. */
function guessStatic(paths: string[]): string | null {
  const captures = paths.filter((path) => CAPTURE.test(path));
  const still = captures.filter((path) => /static|standing|calib|tpose/i.test(path));
  return captures.length === 2 && still.length === 1 ? still[0]! : null;
}
