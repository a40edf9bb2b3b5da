import { Group, SimpleGrid, Text } from "@mantine/core";
import type { ReactNode } from "react";

import { NumberField } from "../../../parts/NumberField";

type Numbers = readonly (number | null | undefined)[] | undefined;
type Props = { legend: string; note?: ReactNode; names: readonly string[]; values: Numbers; set: (values: (number | undefined)[]) => void; errors?: (k: number) => string | undefined };

/** Some numbers that belong together, each with its own name below one legend. */
export function Together({ legend, note, names, values, set, errors }: Props) {
  const all = names.map((_, k) => values?.[k] ?? undefined);
  return (
    <fieldset style={{ border: 0, margin: 0, padding: 0, minInlineSize: 0 }}>
      <Text component="legend" size="sm" fw={500}>
        {legend}
      </Text>
      {note && (
        <Text size="xs" c="dimmed">
          {note}
        </Text>
      )}
      <SimpleGrid cols={names.length} spacing="xs" maw={`${7 * names.length}rem`}>
        {names.map((name, k) => (
          <NumberField key={name} label={name} aria-label={`${legend}: ${name}`} value={all[k]} error={errors?.(k)} set={(value) => set(all.map((each, at) => (at === k ? value : each)))} />
        ))}
      </SimpleGrid>
    </fieldset>
  );
}

/** Fields beside each other where there is room. */
export function Beside({ children }: { children: ReactNode }) {
  return (
    <Group align="flex-start" gap="lg">
      {children}
    </Group>
  );
}
