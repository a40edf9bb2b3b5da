import { Badge, Table, Text, Title } from "@mantine/core";

import type { PayloadFinding } from "../../api/payloadDrafts";
import { capital } from "../../parts/ProblemBox";
import { Said } from "../../parts/Said";
import { number, WideTable } from "../../parts/WideTable";
import { NONE } from "../../parts/digits";

const WORDS = { error: "Error", warning: "Warning", note: "Note" };
const WORST = ["error", "warning", "note"];

/** What the doctor finds in the logs, before anything of them is believed. */
export function PayloadFindings({ findings }: { findings: PayloadFinding[] }) {
  const sorted = [...findings].sort((a, b) => WORST.indexOf(a.severity) - WORST.indexOf(b.severity));
  return (
    <section aria-labelledby="findings">
      <Title order={2} size="h3" id="findings" mb="xs">
        What the checks of the logs found
      </Title>
      {findings.length === 0 ? (
        <Text size="sm">Nothing to find fault with.</Text>
      ) : (
        <WideTable label="What the checks of the logs found" mostHeight="24rem" columns={["Log", "Channel", "Finding", number("Row")]}>
          {sorted.map((each, k) => (
            <Table.Tr key={k} data-finding={each.rule}>
              <Table.Th scope="row">{each.log === "all" ? "all logs" : each.log}</Table.Th>
              <Table.Td>{each.channel}</Table.Td>
              <Table.Td miw="18rem">
                <Badge variant="default" tt="none" mr={6}>
                  {WORDS[each.severity]}
                </Badge>
                <Said words={[sentence(each.detail), sentence(each.advice)].join(" ")} />
              </Table.Td>
              <Table.Td data-number>{each.row ?? NONE}</Table.Td>
            </Table.Tr>
          ))}
        </WideTable>
      )}
    </section>
  );
}

function sentence(words: string): string {
  return words && `${capital(words)}${/[.!?]$/.test(words) ? "" : "."}`;
}
