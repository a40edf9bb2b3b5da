import { Alert, Button, Group, Text } from "@mantine/core";
import { IconPlugConnectedX } from "@tabler/icons-react";
import { useQueryClient } from "@tanstack/react-query";
import { useEffect, useRef } from "react";

import { useHealth } from "../api/health";
import { useAway } from "../api/reachable";
import { SignedOut } from "./SignedOut";
import styles from "./UnreachableBanner.module.css";

const ASK_AGAIN_MS = 5_000;
const LOOK = { root: styles.banner, title: styles.title, icon: styles.icon };

/** Shown while the service does not answer, or lets nobody in. It asks again by itself, and the page goes on where it was. */
export function UnreachableBanner() {
  const away = useAway();
  const cache = useQueryClient();
  const was = useRef(away);

  useEffect(() => {
    if (was.current && !away) void cache.invalidateQueries();
    was.current = away;
  }, [cache, away]);

  return (
    <div role="status" className={styles.place}>
      {away && (away.signedOut ? <SignedOut status={away.status} /> : <Silent words={away.problem.detail} />)}
    </div>
  );
}

function Silent({ words }: { words: string }) {
  const { refetch } = useHealth(ASK_AGAIN_MS);
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
