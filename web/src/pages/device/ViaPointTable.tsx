import { ActionIcon, Group, NativeSelect, NumberInput, Paper, Radio, Slider, Stack, Table, Text, Tooltip } from "@mantine/core";
import { IconPlus, IconTrash } from "@tabler/icons-react";

import type { RobotModel } from "../../api/robots";
import { number, unseen, WideTable } from "../../parts/WideTable";
import type { DeviceContent } from "./deviceFile";
import { tidy, withLink, withNewPoint, withoutPoint, withPoint } from "./edits";
import styles from "./ViaPointTable.module.css";

type Props = {
  model: RobotModel;
  saved: DeviceContent;
  device: DeviceContent;
  band: string;
  point: number;
  choose: (point: number) => void;
  set: (next: DeviceContent, mark: string) => void;
};

const AXES = ["x", "y", "z"] as const;
const REACH_MM = 100;

/** Via points of one band: link and place, in numbers; the chosen one also by sliders. */
export function ViaPointTable({ model, saved, device, band, point, choose, set }: Props) {
  const points = device.bands.find((each) => each.name === band)?.via_points ?? [];
  const links = model.links.map((link) => link.name);
  const place = (k: number, axis: number, value: number) => {
    const at = points[k];
    if (!at) return;
    const xyz = tidy(at.xyz.map((each, j) => (j === axis ? value : each)));
    set(withPoint(device, band, k, { ...at, xyz }), `point ${band} ${k} ${axis}`);
  };
  const chosen = points[point];
  const before = saved.bands.find((each) => each.name === band)?.via_points[point];
  return (
    <Stack gap="sm">
      <WideTable
        label={`Via points of ${band}`}
        tight
        columns={["Point", "Link", ...AXES.map((axis) => number(axis, "m")), unseen("Add or remove")]}
      >
        {points.map((each, k) => (
          <Table.Tr key={k}>
            <Table.Th scope="row">
              <Radio name="point" label={k + 1} aria-label={`Move point ${k + 1} by sliders`} checked={k === point} onChange={() => choose(k)} />
            </Table.Th>
            <Table.Td>
              <NativeSelect
                size="xs"
                className={styles.link}
                aria-label={`Link of point ${k + 1}`}
                value={each.link}
                data={links.includes(each.link) ? links : [each.link, ...links]}
                onChange={(event) => set(withLink(device, model, band, k, event.currentTarget.value), `link ${band} ${k}`)}
              />
            </Table.Td>
            {AXES.map((axis, j) => (
              <Table.Td key={axis} data-number>
                <NumberInput
                  size="xs"
                  className={styles.number}
                  aria-label={`${axis} of point ${k + 1} [m]`}
                  value={each.xyz[j]}
                  onChange={(next) => typeof next === "number" && place(k, j, next)}
                  onFocus={() => choose(k)}
                  step={0.005}
                  decimalScale={6}
                  min={-100}
                  max={100}
                  hideControls
                />
              </Table.Td>
            ))}
            <Table.Td>
              <Group gap={4} wrap="nowrap">
                <Tooltip label="A new point after this one">
                  <ActionIcon
                    variant="default"
                    aria-label={`Add a point after ${k + 1}`}
                    disabled={points.length >= 50}
                    onClick={() => {
                      set(withNewPoint(device, model, band, k), `add ${band} ${k}`);
                      choose(k + 1);
                    }}
                  >
                    <IconPlus size={14} aria-hidden />
                  </ActionIcon>
                </Tooltip>
                <Tooltip label={points.length > 2 ? "Remove it" : "A band has two points at least"}>
                  <ActionIcon
                    variant="default"
                    aria-label={`Remove point ${k + 1}`}
                    disabled={points.length <= 2}
                    onClick={() => {
                      set(withoutPoint(device, band, k), `remove ${band} ${k} ${points.length}`);
                      choose(Math.max(k - 1, 0));
                    }}
                  >
                    <IconTrash size={14} aria-hidden />
                  </ActionIcon>
                </Tooltip>
              </Group>
            </Table.Td>
          </Table.Tr>
        ))}
      </WideTable>
      {chosen && (
        <Paper withBorder p="md">
          <Text size="sm" fw={600} mb="xs">
            Point {point + 1}, in the frame of {chosen.link}
          </Text>
          <Stack gap="xs">
            {AXES.map((axis, j) => {
              const middle = before?.link === chosen.link ? (before.xyz[j] ?? 0) : 0;
              const offset = 1000 * ((chosen.xyz[j] ?? 0) - middle);
              return (
                <div key={axis} className={styles.offset}>
                  <Text size="sm">{axis}</Text>
                  <Slider
                    thumbLabel={`${axis} of point ${point + 1}, moved by [mm]`}
                    min={before?.link === chosen.link ? -REACH_MM : -1000}
                    max={before?.link === chosen.link ? REACH_MM : 1000}
                    step={1}
                    value={Math.round(offset)}
                    onChange={(value) => place(point, j, middle + value / 1000)}
                    label={(value) => `${value} mm`}
                  />
                  <Text size="sm" ta="right">
                    {offset > 0 ? "+" : ""}
                    {offset.toFixed(1).replace("-", "−")} mm
                  </Text>
                </div>
              );
            })}
          </Stack>
        </Paper>
      )}
    </Stack>
  );
}
