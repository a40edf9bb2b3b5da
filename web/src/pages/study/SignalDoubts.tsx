import { Table, Text, Title } from "@mantine/core";

import { count } from "../../parts/size";
import { WideTable } from "../../parts/WideTable";
import type { Doubt } from "./results";

const MOST_NAMED = 4;
const SHOWN_FIRST = 3;
const ORDER = ["error", "warning", "note"];

/** What the checks of the signals found, one row per rule: how often, where, and what to do; three first, the rest folded. */
export function SignalDoubts({ found }: { found: Doubt[] }) {
  const rules = new Map<string, Doubt[]>();
  for (const each of found) {
    const key = `${each.severity}|${each.rule}`;
    rules.set(key, [...(rules.get(key) ?? []), each]);
  }
  const rows = [...rules.values()].sort((one, two) => rank(one) - rank(two));
  return (
    <section aria-labelledby="signals">
      <Title order={2} size="h3" id="signals" mb="sm">
        Signals
      </Title>
      {rows.length === 0 ? (
        <Text size="sm">The checks of the signals found nothing to remark.</Text>
      ) : (
        <>
          <Rules rows={rows.slice(0, SHOWN_FIRST)} label="What matters most of what the checks of the signals found" />
          {rows.length > SHOWN_FIRST && (
            <details>
              <summary>{count(rows.length - SHOWN_FIRST, "more rule")}</summary>
              <Rules rows={rows.slice(SHOWN_FIRST)} label="What else the checks of the signals found" />
            </details>
          )}
        </>
      )}
    </section>
  );
}

function Rules({ rows, label }: { rows: Doubt[][]; label: string }) {
  return (
    <WideTable label={label} columns={["Rule", "How often", "Where", "An example", "What to do"]}>
      {rows.map((doubts) => (
        <Row key={`${doubts[0]?.severity}${doubts[0]?.rule}`} doubts={doubts} />
      ))}
    </WideTable>
  );
}

function Row({ doubts }: { doubts: Doubt[] }) {
  const first = doubts[0] as Doubt;
  const channels = [...new Set(doubts.map((each) => each.channel ?? each.log))];
  const logs = new Set(doubts.map((each) => each.log)).size;
  const more = channels.length - MOST_NAMED;
  return (
    <Table.Tr>
      <Table.Th scope="row">
        {first.rule.replaceAll("_", " ")}{" "}
        <Text span size="xs" c="dimmed">
          {first.severity}
        </Text>
      </Table.Th>
      <Table.Td>{count(doubts.length, "time")}, {count(logs, "log")}</Table.Td>
      <Table.Td>
        {channels.slice(0, MOST_NAMED).join(", ")}
        {more > 0 && ` and ${more} more`}
      </Table.Td>
      <Table.Td>
        {first.log}: {first.detail}
      </Table.Td>
      <Table.Td>{first.advice}</Table.Td>
    </Table.Tr>
  );
}

function rank(doubts: Doubt[]): number {
  return ORDER.indexOf(doubts[0]?.severity ?? "");
}
