import { List, Text, Title } from "@mantine/core";

import type { PayloadResults } from "../../api/payloads";
import { Said } from "../../parts/Said";

/** What a rigid body behind an ideal sensor lacks, as the server says it. */
export function Missing({ missing }: Pick<PayloadResults, "missing">) {
  if (!missing) return null;
  const effects = [...missing.found, ...missing.suspected];
  return (
    <section aria-labelledby="missing">
      <Title order={2} size="h3" id="missing" mb="xs">
        What the model lacks
      </Title>
      <Text style={{ maxWidth: "60rem" }}>
        <Said words={missing.said} />
      </Text>
      {effects.length > 0 && (
        <List size="sm" mt="xs">
          {effects.map(({ effect, place, said }) => (
            <List.Item key={`${effect} ${place}`}>
              <Said words={said} />
            </List.Item>
          ))}
        </List>
      )}
    </section>
  );
}
