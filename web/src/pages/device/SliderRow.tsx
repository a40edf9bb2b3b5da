import { NumberInput, Slider, Text } from "@mantine/core";

import styles from "./SliderRow.module.css";

type Props = {
  name: string;
  unit: string;
  value: number | undefined;
  lowest: number;
  highest: number;
  step: number;
  decimals: number;
  set: (value: number) => void;
};

/** A value by slider and by number; arrow keys work on both. */
export function SliderRow({ name, unit, value, lowest, highest, step, decimals, set }: Props) {
  const label = `${name} [${unit}]`;
  return (
    <div className={styles.row}>
      <Text size="sm">{name}</Text>
      <Slider
        className={styles.slider}
        thumbLabel={`${label}, slider`}
        min={lowest}
        max={highest}
        step={step}
        value={Math.min(Math.max(value ?? lowest, lowest), highest)}
        onChange={(next) => set(Number(next.toFixed(decimals)))}
        label={(each) => each.toFixed(decimals)}
        disabled={value === undefined}
      />
      <NumberInput
        aria-label={label}
        rightSection={<Text size="xs" c="dimmed">{unit}</Text>}
        rightSectionWidth={46}
        hideControls
        step={step}
        decimalScale={decimals + 2}
        value={value ?? ""}
        placeholder="not known"
        onChange={(next) => typeof next === "number" && set(next)}
      />
    </div>
  );
}
