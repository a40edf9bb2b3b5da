import { Table, Text } from "@mantine/core";
import { Fragment } from "react";

import { significant } from "../../parts/digits";
import { Uncertain } from "../../parts/Uncertain";
import { number, numbers, WideTable } from "../../parts/WideTable";
import { APPROACHES } from "./approaches";
import type { Support } from "./results";

/** The same phase by phase: what the wear gives while the body lowers, holds, raises. */
export function PhaseTable({ motion, rows }: { motion: string; rows: Support[] }) {
  const phased = rows.filter((each) => each.phases.length);
  if (!phased.length) return null;
  return (
    <details style={{ marginTop: "0.5rem", fontSize: "var(--mantine-font-size-sm)" }}>
      <summary>Phase by phase</summary>
      <WideTable
        label={`Supporting torque, motion ${motion}, phase by phase`}
        columns={["Joint, device", "Phase", number("Duration"), "Approach", ...numbers("Peak ± std", "Mean ± std", "Integral ± std")]}
      >
        {phased.map((each) => (
          <Fragment key={`${each.device} ${each.joint}`}>
            {each.phases.map((part) =>
              APPROACHES.filter(({ key }) => (key === "A" || key === "B" || key === "paired") && part.approaches[key]).map(({ key, words }) => (
                <Table.Tr key={`${part.phase} ${key}`}>
                  <Table.Th scope="row">
                    {each.joint}{" "}
                    <Text span size="xs" c="dimmed" fw={400}>
                      {each.device}
                    </Text>
                  </Table.Th>
                  <Table.Td>{part.phase}</Table.Td>
                  <Table.Td data-number>{significant(part.duration_s)} s</Table.Td>
                  <Table.Td>{words}</Table.Td>
                  {(["peak", "mean", "integral"] as const).map((quantity) => (
                    <Table.Td key={quantity} data-number>
                      <Uncertain {...part.approaches[key]![quantity]} />
                    </Table.Td>
                  ))}
                </Table.Tr>
              )),
            )}
          </Fragment>
        ))}
      </WideTable>
    </details>
  );
}
