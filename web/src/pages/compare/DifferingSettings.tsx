import { Code, Stack, Table, Text, Title } from "@mantine/core";

import type { Comparison } from "../../api/compare";
import { NONE } from "../../parts/digits";
import { WideTable } from "../../parts/WideTable";
import { jobNames } from "./heads";

/** What could make numbers differ: settings, versions, the files by their hash. */
export function DifferingSettings({ comparison }: { comparison: Comparison }) {
  const names = jobNames(comparison);
  if (names.length < 2) return null;
  return (
    <Stack component="section" gap="sm" aria-labelledby="settings">
      <Title order={2} size="h3" id="settings">
        What else differs
      </Title>
      {comparison.settings.length === 0 ? (
        <Text>Settings, versions and files are the same.</Text>
      ) : (
        <WideTable label="What else differs" mostHeight="24rem" tight columns={["Setting", ...names]}>
          {comparison.settings.map(({ name, values }) => (
            <Table.Tr key={name}>
              <Table.Th scope="row">{name.replace(/^inputs\./, "file ")}</Table.Th>
              {values.map((value, k) => (
                <Table.Td key={k}>{shown(name, value)}</Table.Td>
              ))}
            </Table.Tr>
          ))}
        </WideTable>
      )}
    </Stack>
  );
}

function shown(name: string, value: unknown) {
  if (value === null || value === undefined) return NONE;
  const text = typeof value === "string" ? value : JSON.stringify(value);
  return name.startsWith("inputs.") ? <Code>{text.slice(0, 12)}…</Code> : text;
}
