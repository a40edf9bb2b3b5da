import { Button, Group, Stack, Textarea } from "@mantine/core";
import { useState } from "react";
import { stringify } from "yaml";

type Props = { mapping: object | string | undefined; text: string | null; set: (text: string | null) => void };

/** The same as a mapping.yaml: to keep, to hand in beside a study, or to write what the table cannot say. */
export function MappingText({ mapping, text, set }: Props) {
  const [shown, show] = useState(false);
  const written = text ?? (mapping ? stringify(mapping, { lineWidth: 120 }) : "");
  if (!shown && text === null) {
    return (
      <Group>
        <Button variant="subtle" size="xs" onClick={() => show(true)}>
          Show it as mapping.yaml
        </Button>
      </Group>
    );
  }
  return (
    <Stack gap="xs">
      <Textarea
        label="mapping.yaml"
        description="What is written here counts instead of the table."
        autosize
        minRows={6}
        maxRows={24}
        value={written}
        onChange={(event) => set(event.currentTarget.value)}
        styles={{ input: { fontFamily: "var(--mantine-font-family-monospace)" } }}
        spellCheck={false}
      />
      <Group gap="xs">
        <Button
          variant="default"
          size="xs"
          onClick={() => {
            set(null);
            show(false);
          }}
        >
          {text === null ? "Hide it" : "Back to the table, without what was written"}
        </Button>
        <Button component="a" variant="default" size="xs" download="mapping.yaml" href={`data:text/yaml;charset=utf-8,${encodeURIComponent(written)}`}>
          Save it as a file
        </Button>
      </Group>
    </Stack>
  );
}
