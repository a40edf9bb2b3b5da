import { Stack, Table, Text, Title } from "@mantine/core";

import type { Payload, PayloadResults } from "../../api/payloads";
import { significant } from "../../parts/digits";
import { number, WideTable } from "../../parts/WideTable";
import { BeforeAfter, type ErrorRow } from "../study/BeforeAfter";

const WAYS = [
  ["static", "postures alone, inertia ignored"],
  ["level", "base taken to be level"],
  ["rigid", "without what was named missing"],
  ["all", "everything taken out"],
] as const;
const NORM = Math.sqrt(8 / Math.PI); // mean length of three independent numbers of unit variance

/** What compensation leaves of the wrench where nothing touches, by each method; the paper's table of it. */
export function Remainders({ payload, results }: { payload: Payload; results: PayloadResults }) {
  const logs = Object.entries(results.tests);
  if (!logs.length) return null;
  const { force_n, moment_nm } = payload.summary.sensor.noise;
  const bars = logs.flatMap(([log, ways]): ErrorRow[] => {
    const [before, after] = [ways.static ?? ways.level, ways.all];
    if (!before || !after) return [];
    return [
      { name: `${log}: force`, before: before.mean[0], after: after.mean[0], floor: NORM * force_n, unit: "N", sort: "force" },
      { name: `${log}: moment`, before: before.mean[1], after: after.mean[1], floor: NORM * moment_nm, unit: "N·m", sort: "moment" },
    ];
  });
  return (
    <section aria-labelledby="left">
      <Title order={2} size="h3" id="left" mb="xs">
        What is left where nothing touches
      </Title>
      <Stack gap="sm">
        <Text size="sm" c="dimmed" style={{ maxWidth: "60rem" }}>
          Mean length of the force and of the moment after compensation: before, with what the postures alone told; after, with
          everything; and what the stated noise of the sensor alone makes.
        </Text>
        {bars.length > 0 && <BeforeAfter name="What is left, before and after" rows={bars} />}
        <WideTable
          label="What is left by method"
          columns={[
            "Log", "Compensated by", number("|f| at t = 0", "N"), number("mean |f|", "N"), number("std |f|", "N"),
            number("|τ| at t = 0", "N·m"), number("mean |τ|", "N·m"), number("std |τ|", "N·m"),
            number("largest |f| per axis", "N"), number("after the second zero", "N"),
          ]}
        >
          {logs.flatMap(([log, ways]) =>
            WAYS.flatMap(([way, words]) => {
              const left = ways[way];
              if (!left) return [];
              const cells = [0, 1].flatMap((k) => [left.first[k], left.mean[k], left.std[k]]);
              return (
                <Table.Tr key={`${log} ${way}`} data-left={`${log}|${way}`}>
                  <Table.Th scope="row">{log}</Table.Th>
                  <Table.Td>{words}</Table.Td>
                  {[...cells, Math.max(...left.most.slice(0, 3)), Math.max(...left.after_zero.most.slice(0, 3))].map((cell, k) => (
                    <Table.Td key={k} data-number>
                      {significant(cell)}
                    </Table.Td>
                  ))}
                </Table.Tr>
              );
            }),
          )}
        </WideTable>
      </Stack>
    </section>
  );
}
