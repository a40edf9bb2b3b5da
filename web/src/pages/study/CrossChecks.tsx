import { Table } from "@mantine/core";

import { fixed, isNumber, NONE, significant } from "../../parts/digits";
import { count } from "../../parts/size";
import { number, unseen, WideTable } from "../../parts/WideTable";
import type { StiffnessCheck } from "./results";
import { capital } from "./words";

const CHECK: Record<StiffnessCheck["check"], string> = {
  approaches: "Approaches",
  repetitions: "One log and the others",
  strokes: "Both ways of a motion",
  pulls: "Hard and soft pulls",
  relaxation: "At once and later",
  sides: "Left and right",
  misfit: "What springs leave",
  halves: "Natural length through a log",
};

/** Parts of the evidence that ought to give one stiffness: which do, and which do not; the worst first. */
export function CrossChecks({ device, checks }: { device: string; checks: StiffnessCheck[] }) {
  if (!checks.length) return null;
  const apart = checks.filter((each) => !each.agrees).length;
  const worst = (each: StiffnessCheck) => Math.abs(each.z ?? 0) / (each.limit ?? 1);
  return (
    <details open={apart > 0}>
      <summary>
        What ought to agree: {apart ? `${apart} of ${count(checks.length, "comparison")} do not` : `${count(checks.length, "comparison")}, all within their doubt`}
      </summary>
      <WideTable
        label={`What ought to agree of ${device}`}
        columns={["Group", "Compared", "Between", "By", number("Difference ± std"), number("Difference / std"), number("Limit"), unseen("Whether they agree")]}
        mostHeight="28rem"
      >
        {[...checks]
          .sort((one, other) => Number(one.agrees) - Number(other.agrees) || worst(other) - worst(one))
          .map((each) => (
            <Table.Tr key={`${each.group} ${each.check} ${each.approach} ${each.between.join(" ")} ${each.unit}`} data-agrees={each.agrees}>
              <Table.Th scope="row">{each.group}</Table.Th>
              <Table.Td>{CHECK[each.check]}</Table.Td>
              <Table.Td>{each.between.join(" – ")}</Table.Td>
              <Table.Td>{each.check === "approaches" ? "" : capital(each.approach)}</Table.Td>
              <Table.Td data-number>
                {isNumber(each.difference) ? significant(each.difference, 2) : NONE} ± {isNumber(each.std) ? significant(each.std, 2) : NONE} {each.unit ?? "N/m"}
              </Table.Td>
              <Table.Td data-number>{isNumber(each.z) ? fixed(each.z, 1) : NONE}</Table.Td>
              <Table.Td data-number>{isNumber(each.limit) ? fixed(each.limit, 1) : NONE}</Table.Td>
              <Table.Td>{each.agrees ? (worst(each) > 1 ? "too small to matter" : "") : "do not agree"}</Table.Td>
            </Table.Tr>
          ))}
      </WideTable>
    </details>
  );
}
