import { Autocomplete, Button, NativeSelect, Table, Text } from "@mantine/core";

import type { Column } from "../../api/imports";
import type { ProblemError } from "../../api/refusal";
import { figure, NONE } from "../../parts/digits";
import { channelOf, NOTHING, type Choice } from "./choices";
import styles from "./ColumnRow.module.css";
import { POSE, QUANTITIES, unitsOf, unitWords, WRENCH, XYZ, type Quantity } from "./quantities";

type Props = {
  column: Column;
  choice: Choice;
  set: (choice: Choice) => void;
  joints: string[];
  sensors: string[];
  errors: ProblemError[];
};

const MEANINGS = [
  { value: "", label: "Not said yet" },
  ...Object.entries(QUANTITIES).map(([value, { words }]) => ({ value, label: words })),
  { value: "ignore", label: "Ignore it" },
];

export function ColumnRow({ column, choice, set, joints, sensors, errors }: Props) {
  const { means, unit } = choice;
  const said = means === "" || means === "ignore" ? null : QUANTITIES[means];
  const open = means === "";
  const name = column.name;
  const mean = (value: Choice["means"]) => {
    if (value === "" || value === "ignore") return set({ ...NOTHING, means: value });
    set(started(value, column, choice, sensors));
  };
  return (
    <Table.Tr className={open ? styles.open : undefined}>
      <Table.Th scope="row" className={styles.name}>
        {name}
      </Table.Th>
      <Table.Td className={styles.samples}>
        {column.dtype === "array" ? `${column.shape.join(" × ")} values` : column.samples.slice(0, 3).map((each) => figure(each, 4)).join("  ")}
      </Table.Td>
      <Table.Td data-number>
        {column.min === null ? NONE : `${figure(column.min, 4)}, ${figure(column.max, 4)}`}
      </Table.Td>
      <Table.Td>
        <NativeSelect
          size="xs"
          className={styles.means}
          aria-label={`What ${name} measures`}
          value={means}
          data={MEANINGS}
          onChange={(event) => mean(event.currentTarget.value as Choice["means"])}
        />
      </Table.Td>
      <Table.Td>{said && <Of column={column} choice={choice} set={set} joints={joints} sensors={sensors} />}</Table.Td>
      <Table.Td>
        {said && (
          <>
            <Unit name={name} label="Unit" quantity={means as Quantity} axis={means === "ft" && column.dtype === "array" ? "fx" : choice.axis} value={unit} set={(value) => set({ ...choice, unit: value })} />
            {means === "ft" && column.dtype === "array" && (
              <Unit name={name} label="Unit of the moments" quantity="ft" axis="mx" value={choice.moment_unit} set={(value) => set({ ...choice, moment_unit: value })} />
            )}
          </>
        )}
      </Table.Td>
      <Table.Td>
        {said && means !== "t" && (
          <NativeSelect
            size="xs"
            className={styles.sign}
            aria-label={`Sign of ${name}`}
            value={String(choice.sign)}
            data={[
              { value: "1", label: "+" },
              { value: "-1", label: "−" },
            ]}
            onChange={(event) => set({ ...choice, sign: event.currentTarget.value === "1" ? 1 : -1 })}
          />
        )}
      </Table.Td>
      <Table.Td>
        {said?.of === "joint" && (
          <NativeSelect
            size="xs"
            className={styles.side}
            aria-label={`Side of ${name}`}
            value={choice.side}
            data={["joint", "motor"]}
            onChange={(event) => set({ ...choice, side: event.currentTarget.value as Choice["side"] })}
          />
        )}
      </Table.Td>
      <Table.Td className={styles.words}>
        <Words column={column} choice={choice} errors={errors} set={set} />
      </Table.Td>
    </Table.Tr>
  );
}

/** The joint, the sensor, the axis. */
function Of({ column, choice, set, joints, sensors }: Omit<Props, "errors">) {
  const { means, of, axis } = choice;
  const kind = QUANTITIES[means as Quantity].of;
  const whole = column.dtype === "array";
  const axes = kind === "wrench" ? WRENCH : kind === "pose" ? POSE : XYZ;
  return (
    <div className={styles.of}>
      {kind === "joint" && whole && <Text size="xs">all {joints.length} joints, in the robot’s order</Text>}
      {kind === "joint" && !whole && (
        <Autocomplete size="xs" aria-label={`Joint of ${column.name}`} placeholder="Joint" data={joints} value={of} onChange={(value) => set({ ...choice, of: value })} limit={40} />
      )}
      {kind === "wrench" && (
        <Autocomplete size="xs" aria-label={`Sensor of ${column.name}`} placeholder="Sensor" data={sensors} value={of} onChange={(value) => set({ ...choice, of: value })} />
      )}
      {kind === "wrench" && whole && (
        <NativeSelect
          size="xs"
          aria-label={`Order of ${column.name}`}
          value={choice.order}
          data={[
            { value: "force_first", label: "force first" },
            { value: "couple_first", label: "couple first" },
          ]}
          onChange={(event) => set({ ...choice, order: event.currentTarget.value as Choice["order"] })}
        />
      )}
      {kind !== "joint" && kind !== null && !whole && (
        <NativeSelect
          size="xs"
          aria-label={`Axis of ${column.name}`}
          value={axis}
          data={axes}
          onChange={(event) => set({ ...choice, axis: event.currentTarget.value, unit: unitsOf(means as Quantity, event.currentTarget.value).includes(choice.unit) ? choice.unit : "" })}
        />
      )}
    </div>
  );
}

type UnitProps = { name: string; label: string; quantity: Quantity; axis: string; value: string; set: (unit: string) => void };

function Unit({ name, label, quantity, axis, value, set }: UnitProps) {
  const known = unitsOf(quantity, axis);
  const data = [{ value: "", label: "?" }, ...(value && !known.includes(value) ? [value, ...known] : known).map((unit) => ({ value: unit, label: unitWords(unit) }))];
  return (
    <NativeSelect
      size="xs"
      className={styles.unit}
      aria-label={`${label} of ${name}`}
      value={value}
      data={data}
      error={value === ""}
      onChange={(event) => set(event.currentTarget.value)}
    />
  );
}

/** What keeps it from being read, what it might be, or why it is what it is. */
function Words({ column, choice, errors, set }: Pick<Props, "column" | "choice" | "errors" | "set">) {
  const { suggestion, advice } = column;
  if (choice.means === "ignore") return null;
  if (choice.means === "" && suggestion) {
    const take = () => set({ ...NOTHING, ...channelOf(suggestion.channel), unit: suggestion.unit, sign: suggestion.sign, side: suggestion.side });
    return (
      <>
        <Button size="compact-xs" variant="default" onClick={take} aria-label={`Take ${suggestion.channel}, ${unitWords(suggestion.unit)}: for ${column.name}`}>
          Take {suggestion.channel}, {unitWords(suggestion.unit)}
        </Button>
        <Text size="xs">It may be that: {suggestion.why}.</Text>
      </>
    );
  }
  if (errors.length > 0 && choice.means !== "") {
    return (
      <Text size="xs" c="var(--mantine-color-error)">
        {errors.map((error) => `${error.detail}. ${error.advice ?? ""}`).join(" ")}
      </Text>
    );
  }
  if (choice.means === "") return <Text size="xs">{advice ?? "Say what it measures, or ignore it."}</Text>;
  return suggestion?.sure ? <Text size="xs" c="dimmed">{suggestion.why}</Text> : null;
}

/** With the usual unit only where there is one for certain; a guess is left to a person. */
function started(means: Quantity, column: Column, before: Choice, sensors: string[]): Choice {
  const { suggestion } = column;
  if (suggestion && channelOf(suggestion.channel).means === means) {
    return { ...NOTHING, ...channelOf(suggestion.channel), unit: suggestion.unit, sign: suggestion.sign, side: suggestion.side };
  }
  const of = QUANTITIES[means].of;
  const axis = of === "xyz" || of === "pose" ? "x" : of === "wrench" ? "fx" : "";
  const joint = of === "joint" ? before.of : of === "wrench" && sensors.length === 1 ? (sensors[0] ?? "") : "";
  return { ...NOTHING, means, of: joint, axis };
}
