import { Button, Group, Modal, Stack, Text, TextInput } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import { useState } from "react";

import { useShareDeeds, useShares, type Share } from "../../api/shares";
import { ForMembers } from "../../parts/ForMembers";
import { ProblemBox } from "../../parts/ProblemBox";
import { Row, Rows } from "../../parts/Rows";
import { useDeed } from "../../parts/useDeed";
import { When } from "../../parts/When";

/** Who else may read the study. Nothing for who reads it so, and where there are no accounts. */
export function ShareButton({ id, name }: { id: string; name: string }) {
  const { data } = useShares(id);
  const { share } = useShareDeeds(id);
  const [opened, { open, close }] = useDisclosure(false);
  const { start, busy, error } = useDeed();
  const [lab, setLab] = useState("");
  if (!data) return null;
  const all = data.items.some((each) => each.lab === null);
  return (
    <ForMembers>
      <Button variant="default" onClick={open}>
        Share{data.items.length > 0 && `: ${all ? "every lab" : data.items.length}`}
      </Button>
      <Modal opened={opened} onClose={close} title={`Who may read ${name}`} centered closeButtonProps={{ "aria-label": "Close" }}>
        <Stack>
          <Text size="sm">
            Your lab; beside it those below. They read the study, its jobs and results, change nothing, and find nothing else of yours.
          </Text>
          <form onSubmit={(event) => { event.preventDefault(); start(async () => { await share(lab.trim()); setLab(""); }); }}>
            <Group align="flex-end">
              <TextInput label="Name of another lab" required value={lab} onChange={(event) => setLab(event.currentTarget.value)} />
              <Button type="submit" loading={busy}>
                Share
              </Button>
            </Group>
          </form>
          {!all && (
            <Button variant="default" loading={busy} onClick={() => start(() => share(null))}>
              Share with every lab here
            </Button>
          )}
          {error !== null && <ProblemBox error={error} />}
          <Rows>
            {data.items.map((each) => (
              <ShareRow key={each.id} share={each} study={id} />
            ))}
          </Rows>
        </Stack>
      </Modal>
    </ForMembers>
  );
}

function ShareRow({ share, study }: { share: Share; study: string }) {
  const { end } = useShareDeeds(study);
  const { start, busy, error } = useDeed();
  const who = share.lab ?? "every lab";
  const words = (
    <>
      <Text fw={600}>{share.lab ?? "Every lab of this installation"}</Text>
      <Text size="sm" c="dimmed">
        since <When at={share.created_at} />
      </Text>
      {error !== null && <ProblemBox error={error} />}
    </>
  );
  return (
    <Row words={words}>
      <Button size="xs" variant="default" loading={busy} onClick={() => start(() => end(share.id))}>
        End for {who}
      </Button>
    </Row>
  );
}
