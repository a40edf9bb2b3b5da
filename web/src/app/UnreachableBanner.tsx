import { Alert, Button, Group, Text } from "@mantine/core";
import { IconPlugConnectedX } from "@tabler/icons-react";
import { useQueryClient } from "@tanstack/react-query";
import { useEffect } from "react";

import { useHealth } from "../api/health";
import { useAway } from "../api/reachable";
import styles from "./UnreachableBanner.module.css";

const ASK_AGAIN_MS = 5_000;
const LOOK = { root: styles.banner, title: styles.title, icon: styles.icon };

/** Shown while the service does not answer. It asks again by itself, and the page goes on where it was. */
export function UnreachableBanner() {
  const away = useAway();
  return <div role="status">{away && <Banner words={away.problem.detail} />}</div>;
}

function Banner({ words }: { words: string }) {
  const cache = useQueryClient();
  const { refetch, isSuccess, dataUpdatedAt } = useHealth(ASK_AGAIN_MS);

  useEffect(() => {
    if (isSuccess && dataUpdatedAt) void cache.invalidateQueries({ predicate: (query) => query.queryKey[0] !== "health" });
  }, [cache, isSuccess, dataUpdatedAt]);

  return (
    <Alert color="red" radius={0} icon={<IconPlugConnectedX aria-hidden />} title="The service cannot be reached" classNames={LOOK}>
      <Group justify="space-between" gap="sm">
        <Text size="sm">{words} This page asks again every few seconds; what is shown may be old.</Text>
        <Button size="xs" variant="default" onClick={() => void refetch()}>
          Ask now
        </Button>
      </Group>
    </Alert>
  );
}
