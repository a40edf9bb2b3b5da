import { Anchor, Button, Checkbox, Group, Modal, NativeSelect, Stack, Text, Textarea, TextInput } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import { useState } from "react";
import { Link } from "react-router";

import { usePublicationDeeds, usePublications, type NewPublication, type Publication } from "../../api/publications";
import { useSession } from "../../api/session";
import { ForMembers } from "../../parts/ForMembers";
import { ProblemBox } from "../../parts/ProblemBox";
import { Row, Rows } from "../../parts/Rows";
import { useDeed } from "../../parts/useDeed";
import { When } from "../../parts/When";
import { creatorsOf } from "./creators";

const LICENCES = ["CC-BY-4.0", "CC0-1.0", "CC-BY-SA-4.0", "CC-BY-NC-4.0", "CC-BY-NC-SA-4.0", "ODbL-1.0"];

type Props = { id: string; name: string; jobId: string };

/** A snapshot of what the job found, for everybody; below it those that were published before. */
export function PublishButton({ id, name, jobId }: Props) {
  const { data } = usePublications(id);
  const { data: session } = useSession();
  const { publish } = usePublicationDeeds(id);
  const [opened, { open, close }] = useDisclosure(false);
  const { start, busy, error } = useDeed();
  const [title, setTitle] = useState(name);
  const [creators, setCreators] = useState(session?.account?.name ?? "");
  const [description, setDescription] = useState("");
  const [licence, setLicence] = useState("CC-BY-4.0");
  const [doi, setDoi] = useState("");
  const [inputs, setInputs] = useState(false);
  const before = data?.items[0];
  const [next, setNext] = useState(true);
  if (!data) return null;
  const body: NewPublication = {
    title, creators: creatorsOf(creators), description, licence: licence as NewPublication["licence"], inputs, job_id: jobId, keywords: [],
    doi: doi.trim() || null, follows: before && next ? before.id : null,
  };
  return (
    <ForMembers>
      <Button variant="default" onClick={open}>
        Publish{data.items.length > 0 && `: ${data.items.length}`}
      </Button>
      <Modal opened={opened} onClose={close} title={`Publish ${name}`} centered size="lg" closeButtonProps={{ "aria-label": "Close" }}>
        <Stack>
          <Text size="sm">
            The job’s results become a snapshot that anybody reads without signing in. It never changes, and stays when the study is deleted.
            Revoked, its files go; title, creators and the hash of every file stay at its address.
          </Text>
          <form onSubmit={(event) => { event.preventDefault(); start(async () => void (await publish(body))); }}>
            <Stack gap="sm">
              <TextInput label="Title" required maxLength={200} value={title} onChange={(event) => setTitle(event.currentTarget.value)} />
              <Textarea
                label="Creators, one a line" description="Family, Given; ORCID; affiliation" required autosize value={creators}
                onChange={(event) => setCreators(event.currentTarget.value)}
              />
              <Textarea label="Abstract" autosize maxLength={10000} value={description} onChange={(event) => setDescription(event.currentTarget.value)} />
              <Group align="flex-end">
                <NativeSelect label="Licence" data={LICENCES} value={licence} onChange={(event) => setLicence(event.currentTarget.value)} />
                <TextInput label="DOI, if one is reserved" placeholder="10.…" value={doi} onChange={(event) => setDoi(event.currentTarget.value)} />
              </Group>
              <Checkbox label="Robot, logs and device too" checked={inputs} onChange={(event) => setInputs(event.currentTarget.checked)} />
              {before && <Checkbox label={`As version ${before.version + 1} of ${before.title}`} checked={next} onChange={(event) => setNext(event.currentTarget.checked)} />}
              {error !== null && <ProblemBox error={error} />}
              <Group justify="flex-end">
                <Button type="submit" loading={busy}>
                  Publish for everybody
                </Button>
              </Group>
            </Stack>
          </form>
          <Rows>
            {data.items.map((each) => (
              <PublicationRow key={each.id} found={each} study={id} />
            ))}
          </Rows>
        </Stack>
      </Modal>
    </ForMembers>
  );
}

function PublicationRow({ found, study }: { found: Publication; study: string }) {
  const { revoke } = usePublicationDeeds(study);
  const { start, busy, error } = useDeed();
  const [asking, setAsking] = useState(false);
  const [reason, setReason] = useState("");
  const words = (
    <>
      <Anchor component={Link} to={`/published/${found.key}`} fw={600}>
        {found.title}, version {found.version}
      </Anchor>
      <Text size="sm" c="dimmed">
        {found.revoked_at ? "revoked " : "published "}
        <When at={found.revoked_at ?? found.created_at} />
      </Text>
      {asking && (
        <TextInput label="Why, told at its address" required value={reason} onChange={(event) => setReason(event.currentTarget.value)} />
      )}
      {error !== null && <ProblemBox error={error} />}
    </>
  );
  return (
    <Row words={words}>
      {found.revoked_at === null &&
        (asking ? (
          <Group gap="xs">
            <Button size="xs" variant="default" onClick={() => setAsking(false)}>
              Keep it
            </Button>
            <Button size="xs" color="red" disabled={!reason.trim()} loading={busy} onClick={() => start(async () => void (await revoke(found.id, reason)))}>
              Revoke it
            </Button>
          </Group>
        ) : (
          <Button size="xs" variant="default" onClick={() => setAsking(true)}>
            Revoke version {found.version}
          </Button>
        ))}
    </Row>
  );
}
