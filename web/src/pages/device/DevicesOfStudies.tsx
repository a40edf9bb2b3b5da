import { Button, Text, Title } from "@mantine/core";
import { useNavigate } from "react-router";

import type { Device } from "../../api/devices";
import { useEveryStudy, type Study } from "../../api/studies";
import { partsOf, useTakeDevice } from "../../api/studyParts";
import { ForMembers } from "../../parts/ForMembers";
import { ProblemBox } from "../../parts/ProblemBox";
import { Row, Rows } from "../../parts/Rows";
import { isFound } from "../../parts/useSought";

/** Devices that came with studies and are not in the list, of those that are searched for. words: of the search, may be empty. */
export function DevicesOfStudies({ devices, words }: { devices: Device[]; words: string }) {
  const { studies } = useEveryStudy();
  const take = useTakeDevice();
  const navigate = useNavigate();
  const listed = new Set(devices.map((device) => device.summary.name));
  const found = new Map<string, { study: Study; file: string }>();
  for (const study of studies) {
    for (const { name, file } of partsOf(study).devices ?? []) {
      if (!listed.has(name) && !found.has(name) && isFound(words, name)) found.set(name, { study, file });
    }
  }
  if (found.size === 0) return null;
  return (
    <section aria-labelledby="devices-of-studies">
      <Title order={2} size="h3" id="devices-of-studies" mb="sm">
        In your studies
      </Title>
      {take.error && <ProblemBox error={take.error} />}
      <Rows>
        {[...found].map(([name, from]) => (
          <Row
            key={name}
            words={
              <>
                <Text fw={600}>{name}</Text>
                <Text size="sm" c="dimmed">
                  {from.file} of the study {from.study.name}
                </Text>
              </>
            }
          >
            <ForMembers>
            <Button
              variant="default"
              aria-label={`Add it to the list: ${name}`}
              loading={take.isPending && take.variables.file === from.file}
              onClick={() => take.mutate(from, { onSuccess: (device) => void navigate(`/devices/${device.id}`) })}
            >
              Add it to the list
            </Button>
            </ForMembers>
          </Row>
        ))}
      </Rows>
    </section>
  );
}
