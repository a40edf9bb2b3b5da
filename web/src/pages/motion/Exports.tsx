import { Anchor, Checkbox, Group, Stack, Text, Title } from "@mantine/core";
import { useState } from "react";

import { planExport, type Plan } from "../../api/motions";
import { NumberField } from "../../parts/NumberField";

const FORMATS: [string, string][] = [
  ["csv", "CSV: t, q.joint"],
  ["hrpsys", "hrpsys: .pos .vel .zmp .waist .hip"],
  ["mc_rtc", "mc_rtc"],
  ["ros2-yaml", "ROS 2 JointTrajectory, YAML"],
  ["ros2-mcap", "ROS 2 JointTrajectory, MCAP"],
  ["mujoco", "MuJoCo npz"],
  ["mot", "MOT"],
];

/** The motion as files that robots and simulators play. */
export function Exports({ plan }: { plan: Plan }) {
  const [rate, setRate] = useState<number | undefined>();
  const [despite, allow] = useState(false);
  const broken = plan.found!.broken.length > 0;
  const standing = plan.found!.margins.weight_carried !== null;
  return (
    <section aria-labelledby="exports">
      <Title order={2} size="h3" id="exports" mb="xs">
        For a robot or a simulator
      </Title>
      <Stack gap="sm">
        <Group gap="lg" align="flex-end">
          {standing && <NumberField label="Samples per second" placeholder={plan.found!.rate_hz.toFixed(0)} value={rate} set={setRate} maw={180} />}
          {broken && <Checkbox label="Although a bound is broken; the files are marked" checked={despite} onChange={(event) => allow(event.currentTarget.checked)} />}
        </Group>
        {broken && !despite ? (
          <Text size="sm">Nothing is handed out of a motion that breaks a bound.</Text>
        ) : (
          <Group gap="md">
            {FORMATS.filter(([format]) => standing || format === "csv").map(([format, words]) => (
              <Anchor key={format} href={planExport(plan.id, format, rate, despite)} download size="sm" underline="always">
                {words}
              </Anchor>
            ))}
          </Group>
        )}
        <Text size="xs" c="dimmed">
          {standing
            ? "Each comes as a zip with a sheet of ranges, top speeds, margins and hashes; at another rate it is judged anew. CSV as it was planned is the table itself."
            : "The table itself, as it was planned."}
        </Text>
      </Stack>
    </section>
  );
}
