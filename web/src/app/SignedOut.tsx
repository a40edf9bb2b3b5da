import { Alert, Button, Group, Text } from "@mantine/core";
import { IconExternalLink, IconLock } from "@tabler/icons-react";

import { useLetIn } from "../api/health";
import { root } from "./base";
import styles from "./UnreachableBanner.module.css";

const ASK_AGAIN_MS = 5_000;
const LOOK = { root: styles.banner, title: styles.title, icon: styles.icon };

/** Said while a guard in front of the service answers in its place. Loading the page anew leads to its sign-in. */
export function SignedOut({ status }: { status: number }) {
  useLetIn(ASK_AGAIN_MS);
  const title =
    status === 403 ? "Your session has expired, you are not signed in, or you may not do this" : "Your session has expired, or you are not signed in";
  return (
    <Alert role="alert" color="red" radius={0} icon={<IconLock aria-hidden />} title={title} classNames={LOOK}>
      <Group justify="space-between" gap="sm">
        <Text size="sm" className={styles.words}>
          Sign in again. What you typed on this page stays. Signed in in another tab, this page goes on by itself, with uploads
          too; after signing in here, choose the same files again, and they go on where they were.
        </Text>
        <Group gap="xs">
          <Button size="xs" onClick={() => window.location.reload()}>
            Sign in again
          </Button>
          <Button
            size="xs"
            variant="default"
            component="a"
            href={root.href}
            target="_blank"
            rel="noopener"
            rightSection={<IconExternalLink size={14} aria-hidden />}
          >
            In another tab
          </Button>
        </Group>
      </Group>
    </Alert>
  );
}
