import { Alert, Button, Code, Group, Text } from "@mantine/core";
import { useClipboard } from "@mantine/hooks";

type Props = { title: string; secret: string; onDone: () => void };

/** A secret that nobody can look up again. */
export function ShownOnce({ title, secret, onDone }: Props) {
  const { copied, error, copy } = useClipboard({ timeout: 2000 });
  return (
    <Alert title={title} role="alert">
      <Text size="sm">It is shown this once, and kept nowhere.</Text>
      <Code block my="xs" data-testid="secret">
        {secret}
      </Code>
      <Group gap="xs">
        <Button size="xs" onClick={() => copy(secret)}>
          {copied ? "Copied" : "Copy"}
        </Button>
        <Button size="xs" variant="default" onClick={onDone}>
          Done
        </Button>
        {error && <Text size="sm">This browser copies only over https: select the words above and copy them.</Text>}
      </Group>
    </Alert>
  );
}
