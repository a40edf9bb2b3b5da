import { Button, Group, Text, TextInput } from "@mantine/core";
import { IconSearch } from "@tabler/icons-react";

import type { Sought } from "./useSought";

const LONGEST = 200;

export function SearchBox({ what, placeholder, sought }: { what: string; placeholder: string; sought: Sought }) {
  return (
    <TextInput
      aria-label={`Search ${what}`}
      placeholder={placeholder}
      type="search"
      maxLength={LONGEST}
      flex="1 1 10rem"
      maw="26rem"
      leftSection={<IconSearch size={16} aria-hidden />}
      value={sought.typed}
      onChange={(event) => sought.type(event.currentTarget.value)}
    />
  );
}

/** In place of a list in which nothing was found. */
export function NothingFound({ sentence, clear }: { sentence: string; clear: () => void }) {
  return (
    <Group gap="sm">
      <Text role="status">{sentence}</Text>
      <Button variant="default" size="xs" onClick={clear}>
        Show all
      </Button>
    </Group>
  );
}
