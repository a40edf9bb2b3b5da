import { Button, Group, Modal, Stack, Text, TextInput, Title } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import { useState } from "react";

import { closeLab, useArrive } from "../../api/session";
import { ProblemBox } from "../../parts/ProblemBox";
import { useDeed } from "../../parts/useDeed";

/** Closes the lab, once its name was typed. */
export function CloseLab({ name }: { name: string }) {
  const [opened, { open, close }] = useDisclosure(false);
  const { start, busy, error } = useDeed();
  const [typed, setTyped] = useState("");
  const arrive = useArrive();
  const shut = async () => {
    await closeLab(typed);
    await arrive("/account");
  };
  return (
    <Stack component="section" aria-labelledby="close-lab" gap="sm" align="flex-start">
      <Title order={2} size="h3" id="close-lab">
        The end of the lab
      </Title>
      <Button variant="default" onClick={open}>
        Close the lab
      </Button>
      <Modal opened={opened} onClose={close} title={`Close ${name}?`} centered closeButtonProps={{ "aria-label": "Close" }}>
        <form onSubmit={(event) => { event.preventDefault(); start(shut); }}>
          <Stack>
            <Text size="sm">
              Nobody comes in any more: no member, no token, no lab that it shares with. For a while who runs this service can open it again; then all of it goes but
              what it has published, and its audit.
            </Text>
            <TextInput label="Type its name" required autoComplete="off" value={typed} onChange={(event) => setTyped(event.currentTarget.value)} />
            {error !== null && <ProblemBox error={error} />}
            <Group justify="flex-end">
              <Button variant="default" onClick={close}>
                Keep it
              </Button>
              <Button type="submit" color="red" loading={busy} disabled={typed !== name}>
                Close it for everybody
              </Button>
            </Group>
          </Stack>
        </form>
      </Modal>
    </Stack>
  );
}
