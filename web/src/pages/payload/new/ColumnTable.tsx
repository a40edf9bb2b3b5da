import { Autocomplete, Group, NativeSelect, Table, Text } from "@mantine/core";
import { useMemo } from "react";

import type { Look } from "../../../api/payloadDrafts";
import { figure, NONE } from "../../../parts/digits";
import { number, WideTable } from "../../../parts/WideTable";
import { unitsOf, unitWords } from "../../import/quantities";
import { WRENCH, XYZ, type Content } from "./content";
import { wordsOf, type Fault } from "./faults";

type Columns = Look["logs"][number]["columns"];
type Row = { key: string; label: string; column: string; set: (column: string) => void; left?: string };

/** Which column is what, with what the logs hold in it: that tells a wrong unit or a wrong column by sight. */
export function ColumnTable({ content, set, look, faults, says }: {
  content: Content;
  set: (change: (content: Content) => Content) => void;
  look: Look | undefined;
  faults: readonly Fault[];
  says: (key: string) => string | undefined;
}) {
  const columns = useMemo(() => new Map((look?.logs ?? []).flatMap((log) => log.columns.map((each) => [each.name, each] as const))), [look]);
  const rows = rowsOf(content, set);
  return (
    <WideTable label="Columns" mostHeight="36rem" columns={["Quantity", "Column", number("Smallest, largest"), "What to know"]}>
      {rows.map(({ key, label, column, set: choose, left }) => {
        const seen = columns.get(column);
        const wrong = faults.filter((fault) => fault.file && fault.file !== "payload.yaml" && fault.column === column);
        const said = says(key);
        return (
          <Table.Tr key={key} data-quantity={key}>
            <Table.Th scope="row">{label}</Table.Th>
            <Table.Td>
              <Autocomplete size="xs" miw="11rem" aria-label={`Column of ${label}`} data={[...columns.keys()]} value={column} onChange={choose} limit={60} />
            </Table.Td>
            <Table.Td data-number>{seen ? rangeOf(seen) : NONE}</Table.Td>
            <Table.Td miw="12rem">
              {(said || wrong.length > 0) && (
                <Text size="xs" c="var(--mantine-color-error)">
                  {[said, ...wrong.map((fault) => `${fault.file}${fault.row ? `, row ${fault.row}` : ""}: ${wordsOf(fault)}`)].filter(Boolean).join(" ")}
                </Text>
              )}
              {!said && wrong.length === 0 && (
                <Text size="xs" c="dimmed">
                  {!column ? (left ?? "") : !seen && columns.size > 0 ? "In none of the logs so far." : (seen?.suggestion?.why ?? "")}
                </Text>
              )}
            </Table.Td>
          </Table.Tr>
        );
      })}
    </WideTable>
  );
}

function rangeOf({ min, max }: Columns[number]): string {
  return min === null ? NONE : `${figure(min, 4)}, ${figure(max, 4)}`;
}

function rowsOf({ sensor, pose, time, imu }: Content, set: (change: (content: Content) => Content) => void): Row[] {
  const listed = (key: string, labels: readonly string[], values: readonly string[], put: (content: Content, values: string[]) => Content): Row[] =>
    labels.map((label, k) => ({
      key: `${key}.${k}`,
      label,
      column: values[k] ?? "",
      set: (column) => set((now) => put(now, values.map((each, at) => (at === k ? column : each)))),
    }));
  const rows: Row[] = [{ key: "time.column", label: "time", column: time.column, set: (column) => set((now) => ({ ...now, time: { ...now.time, column } })) }];
  rows.push(...listed("sensor.wrench", WRENCH.map((name) => `${name.startsWith("f") ? "force" : "moment"} ${name.at(-1)}`), sensor.wrench, (now, wrench) => ({ ...now, sensor: { ...now.sensor, wrench } })));
  for (const [joint, column] of Object.entries(pose.joints ?? {})) {
    const put = (chosen: string) => set((now) => ({ ...now, pose: { ...now.pose, joints: { ...now.pose.joints, [joint]: chosen } } }));
    rows.push({ key: `pose.joints.${joint}`, label: `angle of ${joint}`, column, set: put, left: "Left out: it stays at zero." });
  }
  if (pose.rotation) rows.push(...listed("pose.rotation", pose.rotation.map((_, k) => `R ${Math.floor(k / 3) + 1}${(k % 3) + 1} (base ← sensor)`), pose.rotation, (now, rotation) => ({ ...now, pose: { ...now.pose, rotation } })));
  if (pose.quaternion) {
    const order = [...(pose.quaternion_order ?? "xyzw")];
    rows.push(...listed("pose.quaternion", order.map((each) => `quaternion ${each}`), pose.quaternion, (now, quaternion) => ({ ...now, pose: { ...now.pose, quaternion } })));
  }
  if (pose.position) rows.push(...listed("pose.position", XYZ.map((axis) => `position ${axis}`), pose.position, (now, position) => ({ ...now, pose: { ...now.pose, position } })));
  if (imu) rows.push(...listed("imu.acceleration", XYZ.map((axis) => `acceleration ${axis}`), imu.acceleration, (now, acceleration) => ({ ...now, imu: { ...now.imu, acceleration } })));
  return rows;
}

/** One unit for all columns of a quantity. */
export function Units({ content, set }: { content: Content; set: (change: (content: Content) => Content) => void }) {
  const { sensor, pose, time, imu } = content;
  const units: [string, string, string[], (unit: string) => Content][] = [
    ["Time", time.unit, unitsOf("t", ""), (unit) => ({ ...content, time: { ...time, unit } })],
    ["Force", sensor.force_unit ?? "N", unitsOf("ft", "fx"), (force_unit) => ({ ...content, sensor: { ...sensor, force_unit } })],
    ["Moment", sensor.moment_unit ?? "Nm", unitsOf("ft", "mx"), (moment_unit) => ({ ...content, sensor: { ...sensor, moment_unit } })],
  ];
  if (pose.joints) units.push(["Joint angle", pose.angle_unit ?? "rad", ["rad", "deg", "mrad", "rev"], (angle_unit) => ({ ...content, pose: { ...pose, angle_unit } })]);
  if (pose.position) units.push(["Position", pose.position_unit ?? "m", ["m", "mm", "cm"], (position_unit) => ({ ...content, pose: { ...pose, position_unit } })]);
  if (imu) units.push(["Acceleration", imu.unit ?? "m/s^2", unitsOf("acc", ""), (unit) => ({ ...content, imu: { ...imu, unit } })]);
  return (
    <Group gap="md">
      {units.map(([label, value, known, change]) => (
        <NativeSelect
          key={label}
          label={`Unit: ${label.toLowerCase()}`}
          value={value}
          data={(known.includes(value) ? known : [value, ...known]).map((unit) => ({ value: unit, label: unitWords(unit) }))}
          onChange={(event) => {
            const next = change(event.currentTarget.value);
            set(() => next);
          }}
        />
      ))}
    </Group>
  );
}
