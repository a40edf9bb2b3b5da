import { List, Stack, Table, Text, Title } from "@mantine/core";

import { between, fixed, isNumber, NONE, significant } from "../../parts/digits";
import { Uncertain } from "../../parts/Uncertain";
import { number, WideTable } from "../../parts/WideTable";
import { CrossChecks } from "./CrossChecks";
import { DoubtTable } from "./DoubtTable";
import type { Results, Stiffness } from "./results";
import { Skipped } from "./Skipped";
import { capital } from "./words";

const APPROACH: Record<string, string> = { A: "A", B: "B", paired: "Paired", prior: "B, maker’s values" };

/** Stiffness and natural length of each band, by each approach. */
export function StiffnessSection({ results }: { results: Results }) {
  const found = results.stiffness;
  if (!found.length)
    return <Skipped results={results} step="stiffness" advice="It needs logs with the device on, and bands that change their length in them." />;
  const truth = found.some((each) => each.truth_n_per_m !== null);
  const notes = [...new Set(results.stiffness_details.flatMap((each) => each.notes))];
  return (
    <Stack gap="xl">
      <div>
        <Title order={2} size="h3">
          Stiffness and natural length of the bands
        </Title>
        <Text size="sm" c="dimmed">
          Stiffness is the slope of pull over stretch in these motions, of a band with the straps that it hangs on. ± is one standard deviation, the interval holds 95 of 100. {truth && "Error: against the true value, which this device file knows. "}
          “Not decided” means that these motions leave it open.
        </Text>
      </div>
      {[...new Set(found.map((each) => each.device))].map((device) => (
        <section key={device} aria-labelledby={`device-${device}`}>
          <Title order={3} size="h4" id={`device-${device}`} mb="xs">
            {device}
          </Title>
          <Bands device={device} rows={found.filter((each) => each.device === device)} truth={truth} />
          <Doubts rows={found.filter((each) => each.device === device)} />
          <CrossChecks device={device} checks={(results.cross_checks ?? []).filter((each) => each.device === device)} />
        </section>
      ))}
      {notes.length > 0 && (
        <List size="sm">
          {notes.map((note) => (
            <List.Item key={note}>{note}</List.Item>
          ))}
        </List>
      )}
    </Stack>
  );
}

function Bands({ device, rows, truth }: { device: string; rows: Stiffness[]; truth: boolean }) {
  const quantities = [
    number("Stiffness ± std"),
    number("95 % interval", "N/m"),
    ...(truth ? [number("Error")] : []),
    number("Natural length ± std"),
    number("95 % interval", "m"),
  ];
  return (
    <WideTable label={`Bands of ${device}`} columns={["Band", "Approach", ...quantities, "Remark"]}>
      {rows.map((each) => (
        <Table.Tr key={`${each.band} ${each.approach}`} data-band={`${device}|${each.band}|${each.approach}`}>
          <Table.Th scope="row">{each.band}</Table.Th>
          <Table.Td>{APPROACH[each.approach] ?? each.approach}</Table.Td>
          <Table.Td data-number>
            <Uncertain {...each.stiffness_n_per_m} />
          </Table.Td>
          <Table.Td data-number>{between(each.interval_95.stiffness_n_per_m)}</Table.Td>
          {truth && (
            <Table.Td data-number title={isNumber(each.truth_n_per_m) ? `true: ${significant(each.truth_n_per_m, 4)} N/m` : undefined}>
              {isNumber(each.error_percent) ? `${fixed(each.error_percent, Math.abs(each.error_percent) < 10 ? 2 : 0)} %` : NONE}
            </Table.Td>
          )}
          <Table.Td data-number>
            <Uncertain {...each.natural_length_m} />
          </Table.Td>
          <Table.Td data-number>{between(each.interval_95.natural_length_m)}</Table.Td>
          <Table.Td>{remark(each)}</Table.Td>
        </Table.Tr>
      ))}
    </WideTable>
  );
}

/** What the doubt of each group's stiffness is made of, by the approach that comes first in the results. */
function Doubts({ rows }: { rows: Stiffness[] }) {
  const approach = rows.find((each) => each.budget.length)?.approach;
  if (!approach) return null;
  const groups = [...new Set(rows.map((each) => each.group))];
  const budgets = groups.map((group) => rows.find((each) => each.group === group && each.approach === approach)?.budget ?? []);
  const numbers = groups.map((name, k) => ({
    name,
    unit: "N/m",
    parts: budgets[k]!.map(({ source, stiffness_std }) => ({ source, std: stiffness_std })),
  }));
  const sources = [...new Map(budgets.flat().map((part) => [part.source, part])).values()];
  return <DoubtTable summary={`What the doubt of the stiffness by ${APPROACH[approach]} is made of`} numbers={numbers} sources={sources} />;
}

function remark({ identifiable, length_identifiable, note }: Stiffness): string {
  const open = [];
  if (!identifiable) open.push("stiffness");
  if (!length_identifiable) open.push("length");
  return [open.length ? `${capital(open.join(" and "))} not decided.` : "", note].filter(Boolean).join(" ");
}
