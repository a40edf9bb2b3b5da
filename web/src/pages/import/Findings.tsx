import { Badge, Paper, Radio, SimpleGrid, Stack, Table, Text, Title } from "@mantine/core";
import { useMemo, useState } from "react";

import type { Finding } from "../../api/imports";
import { figure, fixed, NONE } from "../../parts/digits";
import { TimePlot } from "../../parts/TimePlot";
import { number, WideTable } from "../../parts/WideTable";

const WORDS = { error: "Error", warning: "Warning", note: "Note" };

/** What the doctor found, and where: the chosen one is marked in the samples around it. */
export function Findings({ findings }: { findings: Finding[] }) {
  const [chosen, choose] = useState<number | null>(null);
  const placed = findings.findIndex((finding) => finding.around !== null);
  const at = chosen !== null && chosen < findings.length ? chosen : placed;
  const finding = findings[at];
  return (
    <section aria-labelledby="findings">
      <Title order={2} size="h3" id="findings" mb="sm">
        What the checks of the signals found
      </Title>
      <SimpleGrid cols={{ base: 1, lg: placed >= 0 ? 2 : 1 }}>
        <WideTable label="What the checks of the signals found" mostHeight="26rem" columns={["Channel", "Finding", number("At", "s")]}>
          {findings.map((each, k) => (
            <Table.Tr key={k}>
              <Table.Th scope="row">
                {each.around ? (
                  <Radio name="finding" label={each.channel} checked={k === at} onChange={() => choose(k)} />
                ) : (
                  each.channel
                )}
              </Table.Th>
              <Table.Td>
                <Badge variant="default" tt="none" mr={6}>
                  {WORDS[each.severity]}
                </Badge>
                {sentence(each.detail)} {sentence(each.advice)}
              </Table.Td>
              <Table.Td data-number>{each.t === null ? NONE : fixed(each.t, 3)}</Table.Td>
            </Table.Tr>
          ))}
        </WideTable>
        {finding?.around && <Around key={at} finding={finding} />}
      </SimpleGrid>
    </section>
  );
}

function sentence(words: string): string {
  return words && `${words.charAt(0).toUpperCase()}${words.slice(1)}${/[.!?]$/.test(words) ? "" : "."}`;
}

function Around({ finding }: { finding: Finding }) {
  const { around, t, channel, row } = finding;
  const lines = useMemo(() => [{ name: channel, values: around?.values ?? [], look: 0 }], [channel, around]);
  const marks = useMemo(() => (t === null ? [] : [{ from: t, to: t }]), [t]);
  if (!around) return null;
  return (
    <Paper withBorder p="sm">
      <Stack gap={4}>
        <TimePlot
          label={`${channel} around ${figure(t, 5)} s, where it is marked: ${finding.detail}`}
          unit={around.unit}
          t={around.t}
          lines={lines}
          marks={marks}
          height={220}
        />
        <Text size="sm" c="dimmed">
          Row {row} of the log, marked, and the samples around it.
        </Text>
      </Stack>
    </Paper>
  );
}
