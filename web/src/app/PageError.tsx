import { Button, Code, Group, Stack, Text, Title } from "@mantine/core";
import { useClipboard } from "@mantine/hooks";
import { useRouteError } from "react-router";

import { Refusal } from "../api/refusal";
import { LinkButton } from "../parts/LinkButton";
import { ProblemBox } from "../parts/ProblemBox";
import styles from "./PageError.module.css";

/** What a page shows when it cannot go on: what happened, and what to do. */
export function PageError() {
  const error = useRouteError();
  if (error instanceof Refusal) return <ProblemBox error={error} />;
  const outdated = error instanceof TypeError && /import|module/i.test(error.message);
  return (
    <Stack gap="sm" align="flex-start" p="md" role="alert">
      <title>Page failed · exogauge</title>
      <Title order={1} size="h2">
        {outdated ? "This page could not be loaded" : "This page has a defect"}
      </Title>
      <Text>
        {outdated
          ? "The service may have been updated or stopped since the page was opened, or your session has expired. Loading it anew helps."
          : "Your data are safe: nothing was changed by this. Load the page anew; if it fails again, report these words."}
      </Text>
      {!outdated && <Code block className={styles.words}>{wordsOf(error)}</Code>}
      <Group>
        <Button onClick={() => window.location.reload()}>Load it anew</Button>
        {!outdated && <CopyDetails error={error} />}
        <LinkButton to="/studies" variant="default">
          To the studies
        </LinkButton>
      </Group>
    </Stack>
  );
}

function CopyDetails({ error }: { error: unknown }) {
  const { copied, error: refused, copy } = useClipboard({ timeout: 2000 });
  const details = () =>
    [
      wordsOf(error),
      `Page: ${window.location.href}`,
      `Time: ${new Date().toISOString()}`,
      `Browser: ${navigator.userAgent}`,
      error instanceof Error ? (error.stack ?? "") : "",
    ].join("\n");
  return (
    <>
      <Button variant="default" onClick={() => copy(details())}>
        {copied ? "Copied" : "Copy the details"}
      </Button>
      {refused && <Text size="sm">This browser copies only over https: select the words above and copy them.</Text>}
    </>
  );
}

function wordsOf(error: unknown): string {
  return error instanceof Error ? `${error.name}: ${error.message}` : String(error);
}
