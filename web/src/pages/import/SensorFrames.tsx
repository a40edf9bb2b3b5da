import { Group, NumberInput, Paper, Text, TextInput } from "@mantine/core";

import type { Preview } from "../../api/imports";
import { AS_IS, sensorsOf, type Whole } from "./choices";

type Props = { preview: Preview; whole: Whole; set: (whole: Whole) => void };

const AXES = /^[+-]?[xyz] [+-]?[xyz] [+-]?[xyz]$/;
const NAMES: Record<string, string> = { acc: "Accelerometer", gyro: "Gyro" };

/** How sensors lie in the log, and the clock. */
export function SensorFrames({ preview, whole, set }: Props) {
  const said = preview.columns.flatMap((column) => {
    const choice = whole.columns[column.name];
    return choice ? [{ column, choice }] : [];
  });
  const sensors = Object.keys(sensorsOf(said));
  const timed = said.some(({ choice }) => choice.means === "t");
  return (
    <Paper withBorder p="md">
      <Group align="flex-start" gap="lg">
        {timed ? (
          <NumberInput
            label="Time stamps are late by [s]"
            description="0 where they are right"
            value={whole.delay}
            step={0.001}
            onChange={(value) => typeof value === "number" && set({ ...whole, delay: value })}
          />
        ) : (
          <NumberInput
            label="Rate of the samples [Hz]"
            description="No column is the time"
            value={whole.rateHz ?? ""}
            min={0}
            error={whole.rateHz ? undefined : "Name the time column, or the rate."}
            onChange={(value) => set({ ...whole, rateHz: typeof value === "number" ? value : null })}
          />
        )}
        {sensors.map((sensor) => {
          const value = whole.frames[sensor] ?? AS_IS;
          return (
            <TextInput
              key={sensor}
              label={`Axes of ${NAMES[sensor] ?? sensor.slice(3)}`}
              description="The log’s, in the order of the robot’s x y z"
              value={value}
              error={AXES.test(value.trim()) ? undefined : "Three axes such as: y -x z"}
              onChange={(event) => set({ ...whole, frames: { ...whole.frames, [sensor]: event.currentTarget.value } })}
            />
          );
        })}
      </Group>
      {sensors.length > 0 && (
        <Text size="sm" c="dimmed" mt="xs">
          “{AS_IS}” takes the axes as they are; “y -x z” says that the robot’s x is the log’s y, its y the log’s −x.
        </Text>
      )}
    </Paper>
  );
}
