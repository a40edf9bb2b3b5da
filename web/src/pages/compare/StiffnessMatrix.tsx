import { Stack, Table, Text, Title } from "@mantine/core";

import type { Comparison } from "../../api/compare";
import { fixed, NONE, plusMinus } from "../../parts/digits";
import { number, WideTable } from "../../parts/WideTable";
import { approachesOf, differs, jobNames } from "./heads";
import { jobColumns, JobHeads } from "./JobHeads";
import styles from "./Matrix.module.css";

/** Stiffness of the bands, by device and band down, jobs and approaches across. */
export function StiffnessMatrix({ comparison, differing }: { comparison: Comparison; differing: boolean }) {
  const names = jobNames(comparison);
  const several = names.length > 1;
  const approaches = approachesOf(comparison.stiffness);
  const bands = [...new Set(comparison.stiffness.map((row) => JSON.stringify([row.device, row.band])))].map((key) => {
    const [device, band] = JSON.parse(key) as [string, string];
    const rows = comparison.stiffness.filter((row) => row.device === device && row.band === band);
    const shown = names.map((_, job) => approaches.map((approach) => rows.find((row) => row.approach === approach)?.cells[job] ?? null));
    return { device, band, shown, truth: rows.flatMap((row) => row.cells).find((cell) => cell?.truth_n_per_m != null)?.truth_n_per_m ?? null };
  });
  const kept = bands.filter(({ shown }) => !differing || !several || differs(shown.map((cells) => cells.map(words).join())));
  if (bands.length === 0) return null;
  return (
    <Stack component="section" gap="sm" aria-labelledby="stiffness">
      <Title order={2} size="h3" id="stiffness">
        Stiffness of the bands
      </Title>
      <WideTable
        label="Stiffness of the bands"
        mostHeight="30rem"
        tight
        above={several && <JobHeads names={names} before={3} across={approaches.length} />}
        columns={["Band", "Device", number("Truth"), ...jobColumns(names, approaches)]}
      >
        {kept.map(({ device, band, shown, truth }) => (
          <Table.Tr key={`${device}|${band}`}>
            <Table.Th scope="row">{band}</Table.Th>
            <Table.Td className={styles.device}>{device}</Table.Td>
            <Table.Td data-number>{fixed(truth, 1)}</Table.Td>
            {shown.map((cells, job) =>
              cells.map((cell, k) => (
                <Table.Td key={`${job} ${k}`} data-number className={several && k === 0 ? styles.job : undefined}>
                  {words(cell)}
                </Table.Td>
              )),
            )}
          </Table.Tr>
        ))}
      </WideTable>
      <Text size="sm" c="dimmed">
        N/m, ± its standard deviation. “Not decided”: the logs do not tell it.
      </Text>
    </Stack>
  );
}

function words(cell: Comparison["stiffness"][number]["cells"][number]): string {
  if (!cell) return NONE;
  const { value, std } = cell.stiffness_n_per_m;
  return cell.identifiable ? plusMinus(value, std) : `${plusMinus(value, std)}, not decided`;
}
