import { Group, NativeSelect, Stack, Switch, Table, Text, Title } from "@mantine/core";

import type { Comparison, SupportRow } from "../../api/compare";
import { fixed, NONE, plusMinus } from "../../parts/digits";
import { WideTable } from "../../parts/WideTable";
import { approachesOf, differs, jobNames } from "./heads";
import { jobColumns, JobHeads } from "./JobHeads";
import type { Quantity, Selection } from "./selection";
import styles from "./Matrix.module.css";

const WORDS: Record<Quantity, string> = {
  peak: "Peak",
  mean: "Mean",
  integral: "Integral over the motion",
  rmse: "RMSE against the band model",
};

type Props = { comparison: Comparison; selection: Selection; select: (change: Partial<Selection>) => void };
type Cell = SupportRow["cells"][number];

/** Supporting torque: device, motion and joint down, jobs and approaches across. */
export function SupportMatrix({ comparison, selection, select }: Props) {
  const { quantity, every, differing } = selection;
  const names = jobNames(comparison);
  const several = names.length > 1;
  const approaches = approachesOf(comparison.support).filter((approach) => quantity !== "rmse" || approach !== "band_model");
  const groups = grouped(comparison.support).filter(
    ({ rows }) => every || rows.some((row) => row.cells.some((cell) => cell?.main)),
  );
  const lines = groups.map((group) => ({
    ...group,
    shown: names.map((_, job) => approaches.map((approach) => group.rows.find((row) => row.approach === approach)?.cells[job] ?? null)),
  }));
  const kept = lines.filter(({ shown }) => !differing || !several || differs(shown.map((cells) => cells.map((cell) => words(cell, quantity)).join())));
  return (
    <Stack component="section" gap="sm" aria-labelledby="support">
      <Group justify="space-between" align="flex-end">
        <Title order={2} size="h3" id="support">
          Supporting torque
        </Title>
        <Group gap="md" align="flex-end" className={styles.controls}>
          <Switch label="Only differences" disabled={!several} checked={differing} onChange={(event) => select({ differing: event.currentTarget.checked })} />
          <Switch label="Every joint" checked={every} onChange={(event) => select({ every: event.currentTarget.checked })} />
          <NativeSelect
            label="Shown"
            value={quantity}
            onChange={(event) => select({ quantity: event.currentTarget.value as Quantity })}
            data={Object.entries(WORDS).map(([value, label]) => ({ value, label }))}
          />
        </Group>
      </Group>
      {kept.length === 0 ? (
        <Text>{comparison.support.length === 0 ? "None of these evaluations had a device worn." : "As shown, all rows are the same in every job."}</Text>
      ) : (
        <WideTable
          label="Supporting torque"
          mostHeight="36rem"
          tight
          above={several && <JobHeads names={names} before={3} across={approaches.length} />}
          columns={["Joint", "Motion", "Device", ...jobColumns(names, approaches)]}
        >
          {kept.map(({ device, motion, joint, shown }) => (
            <Table.Tr key={[device, motion, joint].join("|")}>
              <Table.Th scope="row">{joint}</Table.Th>
              <Table.Td>{motion}</Table.Td>
              <Table.Td className={styles.device}>{device}</Table.Td>
              {shown.map((cells, job) =>
                cells.map((cell, k) => (
                  <Table.Td key={`${job} ${k}`} data-number className={several && k === 0 ? styles.job : undefined}>
                    {words(cell, quantity)}
                  </Table.Td>
                )),
              )}
            </Table.Tr>
          ))}
        </WideTable>
      )}
      <Text size="sm" c="dimmed">
        {quantity === "rmse" ? "Root mean square error (RMSE) against the band model" : WORDS[quantity]} in {unitOf(comparison, quantity)}, positive along the joint{quantity === "rmse" ? "" : ", ± its standard deviation"}.
        {every ? "" : " Joints that the device is for; “Every joint” shows the others."}
      </Text>
    </Stack>
  );
}

function words(cell: Cell, quantity: Quantity): string {
  if (!cell) return NONE;
  if (quantity === "rmse") return cell.rmse === null ? NONE : fixed(cell.rmse, 3);
  const found = cell[quantity];
  return found ? plusMinus(found.value, found.std) : NONE;
}

function unitOf(comparison: Comparison, quantity: Quantity): string {
  const units = comparison.support.flatMap((row) =>
    row.cells.flatMap((cell) => {
      const found = quantity === "rmse" ? cell?.unit : cell?.[quantity]?.unit;
      return found ? [found] : [];
    }),
  );
  return [...new Set(units)].join(" or ") || "N·m";
}

function grouped(rows: SupportRow[]) {
  const found = new Map<string, { device: string; motion: string; joint: string; rows: SupportRow[] }>();
  for (const row of rows) {
    const { device, motion, joint } = row;
    const key = [motion, joint, device].join("\n");
    const group = found.get(key) ?? { device, motion, joint, rows: [] };
    group.rows.push(row);
    found.set(key, group);
  }
  return [...found.values()].sort((a, b) => order(a, b));
}

/** By motion and joint, so that devices stand below each other. */
function order(a: { motion: string; joint: string }, b: { motion: string; joint: string }): number {
  return a.motion.localeCompare(b.motion) || a.joint.localeCompare(b.joint);
}
