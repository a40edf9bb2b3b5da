import { Table, Text } from "@mantine/core";
import { Fragment } from "react";

import { NONE, percent, significant } from "../../parts/digits";
import { Uncertain } from "../../parts/Uncertain";
import { numbers, WideTable } from "../../parts/WideTable";
import { APPROACHES } from "./approaches";
import type { Num, Support } from "./results";

/** Peak and mean with their doubts, and the error of each approach. */
export function SupportTable({ motion, rows }: { motion: string; rows: Support[] }) {
  const rmse = (each: Support): Partial<Record<string, Num>> => ({ A: each.rmse_a, B: each.rmse_b, paired: each.rmse_paired, prior: each.rmse_prior });
  return (
    <WideTable
      label={`Supporting torque, motion ${motion}`}
      columns={["Joint, device", "Approach", ...numbers("RMSE", "Peak ± std", "Mean ± std", "Integral ± std")]}
    >
      {rows.map((each) => {
        const shown = APPROACHES.filter(({ key }) => each.approaches[key]);
        return (
          <Fragment key={`${each.device} ${each.joint}`}>
            {shown.map(({ key, words }, k) => {
              const effort = each.approaches[key]!;
              return (
                <Table.Tr key={key} data-support={`${each.device}|${each.motion}|${each.joint}|${key}`}>
                  {k === 0 && (
                    <Table.Th scope="rowgroup" rowSpan={shown.length} style={{ verticalAlign: "top" }}>
                      {each.joint}
                      <Text size="xs" c="dimmed">
                        {each.device}
                      </Text>
                      <Text size="xs" c="dimmed">
                        {restWords(each)}
                      </Text>
                      {!each.peak && (
                        <Text size="xs" c="dimmed">
                          not decided by the data
                        </Text>
                      )}
                    </Table.Th>
                  )}
                  <Table.Td>{words}</Table.Td>
                  <Table.Td data-number>{key === "band_model" ? NONE : `${significant(rmse(each)[key])} ${each.unit}`}</Table.Td>
                  <Table.Td data-number>
                    <Uncertain {...effort.peak} />
                  </Table.Td>
                  <Table.Td data-number>
                    <Uncertain {...effort.mean} />
                  </Table.Td>
                  <Table.Td data-number>
                    <Uncertain {...effort.integral} />
                  </Table.Td>
                </Table.Tr>
              );
            })}
          </Fragment>
        );
      })}
    </WideTable>
  );
}

function restWords({ rest_share, rest_half_width, unit }: Support): string {
  if (!rest_share) return "";
  return `at rest ${percent(rest_share)} of the time: B within ± ${significant(rest_half_width, 2)} ${unit} there`;
}
