import { NativeSelect, Paper, Stack, Text } from "@mantine/core";

import { BandLawForm } from "./BandLawForm";
import { groupOf, stiffnessOf, type DeviceContent } from "./deviceFile";
import { withLength, withStiffness } from "./edits";
import { SliderRow } from "./SliderRow";

type Props = {
  saved: DeviceContent;
  device: DeviceContent;
  band: string;
  choose: (band: string) => void;
  set: (next: DeviceContent, mark: string) => void;
};

/** Stiffness and law of the chosen band's group, and its natural length. */
export function BandValues({ saved, device, band, choose, set }: Props) {
  const now = device.bands.find((each) => each.name === band);
  const before = saved.bands.find((each) => each.name === band);
  if (!now) return null;
  const group = groupOf(now);
  const members = device.bands.filter((each) => groupOf(each) === group).map((each) => each.name);
  const usual = stiffnessOf(saved, group) ?? 200;
  const length = before?.natural_length_m ?? now.natural_length_m ?? 0.5;
  return (
    <Paper withBorder p="md">
      <Stack gap="sm">
        <NativeSelect
          label="Band"
          value={band}
          onChange={(event) => choose(event.currentTarget.value)}
          data={device.bands.map((each) => each.name)}
        />
        <SliderRow
          name="Stiffness"
          unit="N/m"
          value={stiffnessOf(device, group)}
          lowest={Math.round(usual / 4)}
          highest={Math.round(usual * 4)}
          step={Math.max(Number((usual / 100).toPrecision(1)), 0.1)}
          decimals={1}
          set={(value) => set(withStiffness(device, group, value), `stiffness ${group}`)}
        />
        <SliderRow
          name="Natural length"
          unit="m"
          value={now.natural_length_m}
          lowest={Number(Math.max(length - 0.1, 0.01).toFixed(3))}
          highest={Number((length + 0.1).toFixed(3))}
          step={0.001}
          decimals={3}
          set={(value) => set(withLength(device, band, value), `length ${band}`)}
        />
        {members.length > 1 && (
          <Text size="sm" c="dimmed">
            Bands of group {group} share stiffness and law: {members.join(", ")}.
          </Text>
        )}
        <BandLawForm device={device} group={group} set={set} />
      </Stack>
    </Paper>
  );
}
