import { Button, Group, Modal, Stack, Text } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import { useQueryClient } from "@tanstack/react-query";
import { useNavigate } from "react-router";

import type { ReactNode } from "react";

import { deleteOne, type Deletable } from "../api/deleting";
import { ForMembers } from "./ForMembers";
import { ProblemBox } from "./ProblemBox";
import { useDeed } from "./useDeed";

type Props = { kind: Deletable; id: string; name: string; children: ReactNode };

/** Asks once more, and leads to the list. children: what goes with it, and what stays. */
export function DeleteButton({ kind, id, name, children }: Props) {
  const [opened, { open, close }] = useDisclosure(false);
  const { start, busy, error } = useDeed();
  const cache = useQueryClient();
  const navigate = useNavigate();
  const remove = async () => {
    await deleteOne(kind, id);
    close();
    await navigate(`/${kind}`);
    cache.removeQueries({ queryKey: [kind, id] });
    await cache.invalidateQueries();
  };
  return (
    <ForMembers>
      <Button variant="default" onClick={open}>
        Delete
      </Button>
      <Modal opened={opened} onClose={close} title={`Delete ${name}?`} centered closeButtonProps={{ "aria-label": "Close" }}>
        <Stack>
          <Text size="sm">{children} This cannot be taken back.</Text>
          {error !== null && <ProblemBox error={error} />}
          <Group justify="flex-end">
            <Button variant="default" onClick={close} data-autofocus>
              Keep it
            </Button>
            <Button color="red" loading={busy} onClick={() => start(remove)}>
              Delete
            </Button>
          </Group>
        </Stack>
      </Modal>
    </ForMembers>
  );
}
