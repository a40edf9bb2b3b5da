import { Table, Text, Title } from "@mantine/core";

import type { PayloadResults } from "../../api/payloads";
import { fixed, significant } from "../../parts/digits";
import { number, WideTable } from "../../parts/WideTable";

/** When something touched, and how strongly. */
export function Contacts({ results }: { results: PayloadResults }) {
  const logs = Object.entries(results.contacts);
  if (!logs.length) return null;
  return (
    <section aria-labelledby="contacts">
      <Title order={2} size="h3" id="contacts" mb="xs">
        Contacts
      </Title>
      <Text size="sm" c="dimmed" mb="xs">
        {logs.map(([log]) => `${log}: told from ${significant(results.contact_threshold_n[log])} N on`).join("; ")}. Largest force of
        the environment on the payload, in the sensor’s axes.
      </Text>
      <WideTable label="Contacts" columns={["Log", number("From", "s"), number("To", "s"), number("f_x", "N"), number("f_y", "N"), number("f_z", "N"), number("|f|", "N")]}>
        {logs.flatMap(([log, touches]) =>
          touches.map((touch) => (
            <Table.Tr key={`${log} ${touch.start_s}`} data-contact={log}>
              <Table.Th scope="row">{log}</Table.Th>
              <Table.Td data-number>{fixed(touch.start_s, 2)}</Table.Td>
              <Table.Td data-number>{fixed(touch.end_s, 2)}</Table.Td>
              {[...touch.force_n, Math.hypot(...touch.force_n)].map((value, k) => (
                <Table.Td key={k} data-number>
                  {significant(value)}
                </Table.Td>
              ))}
            </Table.Tr>
          )),
        )}
      </WideTable>
      {logs.every(([, touches]) => touches.length === 0) && <Text size="sm">Nothing touched it.</Text>}
    </section>
  );
}
