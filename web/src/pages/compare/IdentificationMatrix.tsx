import { Stack, Table, Text, Title } from "@mantine/core";

import type { Comparison } from "../../api/compare";
import { fixed, NONE } from "../../parts/digits";
import { number, WideTable } from "../../parts/WideTable";
import { titleOf } from "../study/words";
import { jobNames } from "./heads";

const KINDS: Record<string, string> = {
  base_moment: "Moments of the base",
  trunk_torque: "Torque of the trunk",
  joint_torque: "Torque of all joints",
  joint_force: "Force of sliding joints",
  sensor_force: "Forces of the sensors",
  sensor_moment: "Moments of the sensors",
};
const VERDICTS: Record<string, string> = {
  effects: "something is missing",
  unexplained: "something is missing that no candidate explains",
  undecided: "undecided: too little to judge",
  none: "nothing is missing",
};

/** How well each job's robot predicts logs that it was not fitted to, and what its model lacks. */
export function IdentificationMatrix({ comparison }: { comparison: Comparison }) {
  const names = jobNames(comparison);
  if (comparison.identification.length === 0) return null;
  return (
    <Stack component="section" gap="sm" aria-labelledby="identification">
      <Title order={2} size="h3" id="identification">
        The robot’s model
      </Title>
      <WideTable label="The robot’s model" tight columns={["RMSE", ...names.map((name) => number(name))]}>
        {comparison.identification.map((row) => (
          <Table.Tr key={row.kind}>
            <Table.Th scope="row">
              {KINDS[row.kind] ?? row.kind} [{row.unit}]
            </Table.Th>
            {row.cells.map((cell, k) => (
              <Table.Td key={k} data-number>
                {cell ? `${fixed(cell.rmse_prior, 3)} → ${fixed(cell.rmse_identified, 3)}, floor ${fixed(cell.noise_floor, 3)}` : NONE}
              </Table.Td>
            ))}
          </Table.Tr>
        ))}
        <Table.Tr>
          <Table.Th scope="row">What it lacks</Table.Th>
          {comparison.jobs.map((job) => (
            <Table.Td key={job.id} data-number>
              {job.verdict === null ? "not searched" : job.effects.map(titleOf).join("; ") || VERDICTS[job.verdict]}
            </Table.Td>
          ))}
        </Table.Tr>
      </WideTable>
      <Text size="sm" c="dimmed">
        RMSE, the root mean square error: with the maker’s values → as identified, and the floor that noise sets; on held-out logs where there are some.
      </Text>
    </Stack>
  );
}
