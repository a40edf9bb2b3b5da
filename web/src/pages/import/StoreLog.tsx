import { Button, Checkbox, Group, Stack, Text } from "@mantine/core";

import type { Schemas } from "../../api/client";
import { useCreateLog, useKeepMapping } from "../../api/imports";
import { useKept } from "../../app/kept";
import { ProblemBox } from "../../parts/ProblemBox";
import { useDeed } from "../../parts/useDeed";

type Props = {
  uploadId: string;
  robotId: string | undefined;
  mapping: object | string | undefined;
  ready: boolean;
  stored: (log: Schemas["LogOut"]) => void;
};

/** The file with its mapping becomes a log, and the mapping is kept for the robot's next one. */
export function StoreLog({ uploadId, robotId, mapping, ready, stored }: Props) {
  const [keep, setKeep] = useKept("keep", true);
  const create = useCreateLog();
  const remember = useKeepMapping();
  const { start, busy, error } = useDeed();
  const store = async () => {
    if (keep && robotId && mapping) await remember.mutateAsync({ robotId, mapping });
    stored(await create.mutateAsync({ uploadId, robotId, mapping }));
  };
  return (
    <Stack gap="sm">
      <Group gap="lg">
        <Button disabled={!ready} loading={busy} onClick={() => start(store)}>
          Store the log
        </Button>
        {robotId && (
          <Checkbox label="Keep this mapping for the robot’s next logs" checked={keep} onChange={(event) => setKeep(event.currentTarget.checked)} />
        )}
        {!ready && (
          <Text size="sm" c="dimmed">
            It can be stored once every column is named or ignored.
          </Text>
        )}
      </Group>
      {error !== null && <ProblemBox error={error} />}
    </Stack>
  );
}
