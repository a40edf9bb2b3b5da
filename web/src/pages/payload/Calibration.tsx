import { Stack, Table, Text, Title } from "@mantine/core";

import type { PayloadResults } from "../../api/payloads";
import { significant, withStd } from "../../parts/digits";
import { Said } from "../../parts/Said";
import { Uncertain } from "../../parts/Uncertain";
import { number, WideTable } from "../../parts/WideTable";
import { NAMES } from "./ValueTable";

const CHANNELS = ["f_x", "f_y", "f_z", "τ_x", "τ_y", "τ_z"];
const SURE = 1.96; // standard deviations

type Found = NonNullable<PayloadResults["calibration"]>;

/** Gains and crosstalk of the sensor: what was found and taken out, what may be left, and what that adds to each ±. */
export function Calibration({ results }: { results: PayloadResults }) {
  const found = results.calibration;
  if (!found) return null;
  return (
    <section aria-labelledby="calibration">
      <Title order={2} size="h3" id="calibration" mb="xs">
        Calibration of the sensor
      </Title>
      <Stack gap="sm">
        <Text style={{ maxWidth: "60rem" }}>
          Every ± holds what the sensor’s calibration leaves open: <Said words={found.said} /> {taken(found)}
        </Text>
        <Channels found={found} />
        <Shares found={found} results={results} />
      </Stack>
    </section>
  );
}

function taken({ taken_out, common: [mean, std] }: Found): string {
  const shared = `The gain that all axes share: ${percent(mean, std)}.`;
  const out = "What the data show of gains and crosstalk is taken out of every wrench.";
  return taken_out ? `${out} ${shared}` : `Nothing is taken out. ${shared}`;
}

/** Row: a channel. Column: what it reads of what. */
function Channels({ found: { taken_out, std, common } }: { found: Found }) {
  if (!std?.length) return null;
  const apart = (i: number, k: number) => (taken_out?.[i]?.[k] ?? 0) - (i === k ? common[0] : 0);
  return (
    <>
      <WideTable label="Gains and crosstalk" tight columns={["Channel", ...CHANNELS.map((of) => number(`of ${of}`))]}>
        {CHANNELS.map((channel, i) => (
          <Table.Tr key={channel} data-channel={channel}>
            <Table.Th scope="row">{channel}</Table.Th>
            {CHANNELS.map((of, k) => (
              <Cell key={of} value={apart(i, k)} std={std[i]?.[k] ?? 0} alike={i < 3 === k < 3} />
            ))}
          </Table.Tr>
        ))}
      </WideTable>
      <Text size="sm" c="dimmed" style={{ maxWidth: "60rem" }}>
        What is taken out ± what may be left. On the diagonal: gains against their mean; beside it: what a channel reads of
        another one. In %; of moments in forces N per N·m, of forces in moments N·m per N. Bold: more than chance.
      </Text>
    </>
  );
}

function Cell({ value, std, alike }: { value: number; std: number; alike: boolean }) {
  const sure = Math.abs(value) > SURE * std;
  const [told, doubt] = withStd(alike ? 100 * value : value, alike ? 100 * std : std);
  return (
    <Table.Td data-number fw={sure ? 700 : undefined} data-sure={sure || undefined}>
      {value === 0 ? `0 ± ${doubt}` : `${told} ± ${doubt}`}
    </Table.Td>
  );
}

/** Of each number, how much of its doubt is the sensor's. */
function Shares({ found: { std_without }, results: { static: still, dynamic: moved } }: { found: Found; results: PayloadResults }) {
  const values = [...(moved?.values ?? still?.values ?? []), ...(moved ? (still?.values ?? []).filter(({ name }) => name === "U" || name === "V") : [])];
  const told = values.filter(({ name }) => std_without[name] !== undefined);
  return (
    <WideTable label="Doubt with and without the calibration" mostHeight="24rem" columns={["Quantity", "Unit", number("Used ± std"), number("std with an exact sensor"), number("times")]}>
      {told.map(({ name, unit, value, std }) => (
        <Table.Tr key={name} data-doubt={name}>
          <Table.Th scope="row">{NAMES[name] ?? name}</Table.Th>
          <Table.Td>{unit}</Table.Td>
          <Table.Td data-number>
            <Uncertain value={value} std={std} />
          </Table.Td>
          <Table.Td data-number>{significant(std_without[name]!, 2)}</Table.Td>
          <Table.Td data-number>{significant(std / std_without[name]!, 2)}</Table.Td>
        </Table.Tr>
      ))}
    </WideTable>
  );
}

function percent(value: number, std: number): string {
  const [told, doubt] = withStd(100 * value, 100 * std);
  return value === 0 ? `0 ± ${doubt} %` : `${told} ± ${doubt} %`;
}
