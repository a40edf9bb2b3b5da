import { ActionIcon, Button, Group, SimpleGrid, Stack, Text, Title } from "@mantine/core";
import { IconTrash } from "@tabler/icons-react";
import { useState } from "react";

import { useContacts, useSayContacts, type Contacts, type Feet } from "../../api/motions";
import { figure } from "../../parts/digits";
import { Loading } from "../../parts/Loading";
import { NumberField } from "../../parts/NumberField";
import { ProblemBox } from "../../parts/ProblemBox";
import styles from "./ContactsEditor.module.css";

const FEET = ["left", "right"] as const;
const MOST = 60; // stretches of a foot that are listed

/** When each foot stands: as it was read, or as somebody says it. */
export function ContactsEditor({ motionId }: { motionId: string }) {
  const { data: contacts, error, refetch } = useContacts(motionId);
  return (
    <section aria-labelledby="feet">
      <Title order={2} size="h3" id="feet" mb="xs">
        When the feet stand
      </Title>
      {error && !contacts ? (
        <ProblemBox error={error} retry={() => void refetch()} />
      ) : !contacts ? (
        <Loading what="the contacts" lines={2} />
      ) : (
        <Edit key={JSON.stringify(contacts.said)} motionId={motionId} contacts={contacts} />
      )}
    </section>
  );
}

function Edit({ motionId, contacts }: { motionId: string; contacts: Contacts }) {
  const kept: Feet = contacts.said ?? contacts.read ?? { left: [], right: [] };
  const [feet, setFeet] = useState<Feet>(kept);
  const say = useSayContacts(motionId);
  const changed = JSON.stringify(feet) !== JSON.stringify(kept);
  const wrong = FEET.some((foot) => !inOrder(feet[foot]));
  return (
    <Stack gap="sm">
      <Text size="sm" c="dimmed" style={{ maxWidth: "60rem" }}>
        {contacts.said
          ? "As somebody said it."
          : contacts.read
            ? "As read: a foot stands while one of its points is low and slow."
            : "The feet of this capture are not known: say when they stand."}{" "}
        The robot’s feet stay where they are; a motion in which neither foot stands is refused.
      </Text>
      <SimpleGrid cols={{ base: 1, sm: 2 }}>
        {FEET.map((foot) => (
          <Foot key={foot} foot={foot} seconds={contacts.seconds} spans={feet[foot]} set={(spans) => setFeet({ ...feet, [foot]: spans })} />
        ))}
      </SimpleGrid>
      <Group gap="sm">
        <Button disabled={!changed || wrong} loading={say.isPending} onClick={() => say.mutate(feet)}>
          Keep these contacts
        </Button>
        {changed && (
          <Button variant="default" onClick={() => setFeet(kept)}>
            Undo
          </Button>
        )}
        {contacts.said && (
          <Button variant="default" loading={say.isPending} onClick={() => say.mutate(null)}>
            As read
          </Button>
        )}
        {wrong && <Text size="sm">Stretches follow each other, and each ends after it begins.</Text>}
      </Group>
      {say.error && <ProblemBox error={say.error} />}
    </Stack>
  );
}

type FootProps = { foot: (typeof FEET)[number]; seconds: number; spans: number[][]; set: (spans: number[][]) => void };

function Foot({ foot, seconds, spans, set }: FootProps) {
  const change = (k: number, end: 0 | 1, value: number | undefined) =>
    set(spans.map((span, n) => (n === k ? (end === 0 ? [value ?? 0, span[1] ?? 0] : [span[0] ?? 0, value ?? 0]) : span)));
  const last = spans.at(-1)?.[1] ?? 0;
  const words = spans.length ? spans.map(([begin, end]) => `${figure(begin)} to ${figure(end)} s`).join(", ") : "never";
  return (
    <fieldset className={styles.foot}>
      <legend>{foot === "left" ? "Left foot" : "Right foot"}</legend>
      <svg viewBox={`0 0 ${Math.max(seconds, 1e-3)} 1`} preserveAspectRatio="none" className={styles.bar} role="img" aria-label={`The ${foot} foot stands ${words}`}>
        {spans.map(([begin = 0, end = 0], k) => (
          <rect key={k} x={begin} y={0} width={Math.max(end - begin, 0)} height={1} />
        ))}
      </svg>
      {spans.slice(0, MOST).map((span, k) => (
        <Group key={k} gap="xs" align="flex-end" wrap="nowrap">
          <NumberField size="xs" aria-label={`${foot} foot, stretch ${k + 1}: stands from`} value={span[0]} set={(value) => change(k, 0, value)} rightSection="s" />
          <NumberField size="xs" aria-label={`${foot} foot, stretch ${k + 1}: to`} value={span[1]} set={(value) => change(k, 1, value)} rightSection="s" />
          <ActionIcon variant="subtle" aria-label={`Remove stretch ${k + 1} of the ${foot} foot`} onClick={() => set(spans.filter((_, n) => n !== k))}>
            <IconTrash size={16} aria-hidden />
          </ActionIcon>
        </Group>
      ))}
      {spans.length > MOST && <Text size="xs">{spans.length - MOST} more stretches are not listed.</Text>}
      <Button size="compact-sm" variant="subtle" disabled={last >= seconds} onClick={() => set([...spans, [last, seconds]])}>
        Add a stretch
      </Button>
    </fieldset>
  );
}

function inOrder(spans: number[][]): boolean {
  const flat = spans.flat();
  return flat.every((value, k) => value >= 0 && (k === 0 || value >= (flat[k - 1] ?? 0)));
}
