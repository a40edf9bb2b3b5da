import { Button, Paper, Text, Title } from "@mantine/core";
import { useNavigate } from "react-router";

import type { Device } from "../../api/devices";
import { useStudies, type Study } from "../../api/studies";
import { partsOf, useTakeDevice } from "../../api/studyParts";
import { ProblemBox } from "../../parts/ProblemBox";
import styles from "./DeviceList.module.css";

/** Devices that came with studies and are not in the list. */
export function DevicesOfStudies({ devices }: { devices: Device[] }) {
  const { data } = useStudies();
  const take = useTakeDevice();
  const navigate = useNavigate();
  const listed = new Set(devices.map((device) => device.summary.name));
  const found = new Map<string, { study: Study; file: string }>();
  for (const study of data?.pages.flatMap((page) => page.items) ?? []) {
    for (const { name, file } of partsOf(study).devices ?? []) {
      if (!listed.has(name) && !found.has(name)) found.set(name, { study, file });
    }
  }
  if (found.size === 0) return null;
  return (
    <section aria-labelledby="devices-of-studies">
      <Title order={2} size="h3" id="devices-of-studies" mb="sm">
        In your studies
      </Title>
      {take.error && <ProblemBox error={take.error} />}
      <ul className={styles.list}>
        {[...found].map(([name, from]) => (
          <Paper withBorder component="li" className={styles.row} key={name}>
            <div>
              <Text fw={600}>{name}</Text>
              <Text size="sm" c="dimmed">
                {from.file} of the study {from.study.name}
              </Text>
            </div>
            <Button
              variant="default"
              aria-label={`Add it to the list: ${name}`}
              loading={take.isPending && take.variables.file === from.file}
              onClick={() => take.mutate(from, { onSuccess: (device) => void navigate(`/devices/${device.id}`) })}
            >
              Add it to the list
            </Button>
          </Paper>
        ))}
      </ul>
    </section>
  );
}
