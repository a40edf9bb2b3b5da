import { Paper, SimpleGrid, Text, TextInput, Title } from "@mantine/core";

import { SPECIMEN } from "./differences";
import { RECORD, type DeviceContent, type Specimen } from "./deviceFile";
import { withRecord } from "./edits";

const EXAMPLES: Specimen = {
  model: "SSL-2",
  size: "M",
  serial: "0042",
  straps: "third hole",
  pretension: "none",
  garment: "cotton shirt",
};
const LONGEST = 200; // letters

type Props = { device: DeviceContent; set: (next: DeviceContent, mark: string) => void };

/** Which specimen is worn, and how: no number depends on it, but a result is worth little without. */
export function SpecimenForm({ device, set }: Props) {
  return (
    <Paper withBorder p="md" component="section" aria-labelledby="specimen">
      <Title order={3} size="h4" id="specimen">
        Which one is worn, and how
      </Title>
      <Text size="sm" c="dimmed" mb="xs">
        In your own words. Every report of a study with this device repeats it; what is empty is told as not stated.
      </Text>
      <SimpleGrid cols={{ base: 1, xs: 2, md: 3 }} spacing="sm">
        {RECORD.map((key) => (
          <TextInput
            key={key}
            label={SPECIMEN[key]}
            placeholder={`such as ${EXAMPLES[key]}`}
            maxLength={LONGEST}
            value={device.record[key] ?? ""}
            onChange={(event) => set(withRecord(device, key, event.currentTarget.value), `record ${key}`)}
          />
        ))}
      </SimpleGrid>
    </Paper>
  );
}
