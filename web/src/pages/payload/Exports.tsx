import { Button, Checkbox, Code, CopyButton, Group, NativeSelect, SimpleGrid, Stack, Text, Title } from "@mantine/core";
import { IconCopy, IconDownload } from "@tabler/icons-react";
import { useState } from "react";

import { useTextFile } from "../../api/files";
import { exportAddress, type Payload, type PayloadResults } from "../../api/payloads";
import { isNumber } from "../../parts/digits";
import { Loading } from "../../parts/Loading";
import { NumberField } from "../../parts/NumberField";
import { ProblemBox } from "../../parts/ProblemBox";

const FORMATS = [
  { value: "ur", label: "UR: set_target_payload" },
  { value: "kuka", label: "KUKA: LOAD_DATA" },
  { value: "abb", label: "ABB: loaddata" },
  { value: "urdf", label: "URDF: <inertial>" },
  { value: "sdf", label: "SDFormat: <inertial>" },
  { value: "mjcf", label: "MJCF: <inertial>" },
  { value: "json", label: "JSON" },
  { value: "csv", label: "CSV" },
];
const POSE = ["x [m]", "y [m]", "z [m]", "roll [°]", "pitch [°]", "yaw [°]"];
const OF_FLANGE = ["ur", "kuka", "abb"];

/** The identified body in the words of a robot's model or controller, as it will be written. */
export function Exports({ payload, results }: { payload: Payload; results: PayloadResults }) {
  const [format, setFormat] = useState("ur");
  const [inFlange, setInFlange] = useState(false);
  const [pose, setPose] = useState<(number | undefined)[]>([0, 0, 0, 0, 0, 0]);
  const placed = pose.filter(isNumber);
  const lacking = inFlange && placed.length < POSE.length;
  const href = lacking ? undefined : exportAddress(payload.id, format, inFlange ? placed : null);
  const { data: text, error, isPending } = useTextFile(href);
  return (
    <section aria-labelledby="exports">
      <Title order={2} size="h3" id="exports" mb="xs">
        Export
      </Title>
      <Stack gap="sm">
        <Group align="flex-end" gap="md">
          <NativeSelect label="Format" data={FORMATS} value={format} onChange={(event) => setFormat(event.currentTarget.value)} />
          <Checkbox
            label="In the flange’s frame"
            checked={inFlange}
            onChange={(event) => setInFlange(event.currentTarget.checked)}
            mb={8}
          />
        </Group>
        {inFlange && (
          <fieldset style={{ border: 0, margin: 0, padding: 0 }}>
            <Text component="legend" size="sm" c="dimmed">
              Pose of the sensor in the flange; roll, pitch, yaw about the flange’s fixed x, y, z
            </Text>
            <SimpleGrid cols={{ base: 2, xs: 3, md: 6 }} spacing="xs" maw="48rem">
              {POSE.map((label, k) => (
                <NumberField key={label} label={label} value={pose[k]} set={(value) => setPose((now) => now.map((each, at) => (at === k ? value : each)))} />
              ))}
            </SimpleGrid>
          </fieldset>
        )}
        {!inFlange && OF_FLANGE.includes(format) && (
          <Text size="sm">
            This controller takes it to be in the flange’s frame; what is written below is in the {results.frame}.
          </Text>
        )}
        {lacking ? (
          <Text size="sm">The pose needs all six numbers.</Text>
        ) : error ? (
          <ProblemBox error={error} />
        ) : isPending ? (
          <Loading what="the export" lines={1} />
        ) : (
          <>
            <Code block data-testid="export" tabIndex={0} role="region" aria-label="What is exported" mah="20rem" style={{ overflow: "auto" }}>
              {text}
            </Code>
            <Group gap="sm">
              <Button component="a" href={href} download leftSection={<IconDownload size={16} aria-hidden />}>
                Download
              </Button>
              <CopyButton value={text ?? ""}>
                {({ copied, copy }) => (
                  <Button variant="default" onClick={copy} leftSection={<IconCopy size={16} aria-hidden />}>
                    {copied ? "Copied" : "Copy"}
                  </Button>
                )}
              </CopyButton>
            </Group>
          </>
        )}
      </Stack>
    </section>
  );
}
