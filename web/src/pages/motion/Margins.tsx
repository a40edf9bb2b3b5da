import { Table, Text, Title } from "@mantine/core";

import type { Found } from "../../api/motions";
import { FactList } from "../../parts/FactList";
import { fixed, isNumber, percent } from "../../parts/digits";
import { number, WideTable } from "../../parts/WideTable";

/** What is left of balance and distances, and which bounds bind. */
export function Margins({ found }: { found: Found }) {
  const { margins } = found;
  const [nearest] = margins.bounds;
  const facts: [string, React.ReactNode][] = [];
  if (isNumber(margins.pressure_inside_m)) facts.push(["Centre of pressure", `${fixed(1e3 * margins.pressure_inside_m, 1)} mm inside what the feet stand on, at least`]);
  if (isNumber(margins.weight_carried)) facts.push(["Weight on the feet", `${percent(margins.weight_carried)} at least`]);
  if (isNumber(margins.feet_m) && isNumber(margins.feet_rad)) facts.push(["Feet", `move by ${fixed(1e3 * margins.feet_m, 3)} mm and ${fixed((180 / Math.PI) * margins.feet_rad, 4)}° at most`]);
  if (isNumber(margins.apart_m)) {
    const where = margins.nearest ? `: ${margins.nearest.links.join(" and ")} at ${fixed(margins.nearest.time, 2)} s` : " or more";
    facts.push(["Nearest pair", `${fixed(1e3 * margins.apart_m, 1)} mm${where}`]);
  }
  return (
    <section aria-labelledby="margins">
      <Title order={2} size="h3" id="margins" mb="xs">
        Margins
      </Title>
      {nearest && found.kind === "retarget" && (
        <Text size="sm" mb="xs">
          The bound that binds first: {nearest.kind} of {nearest.joint}, {percent(nearest.share, 1)} of it at {fixed(nearest.time, 2)} s.
        </Text>
      )}
      <FactList facts={facts} />
      <WideTable label="Bounds" columns={["Bound", "Joint that comes nearest", number("share of it"), number("at", "s")]}>
        {margins.bounds.map((each) => (
          <Table.Tr key={each.kind} data-bound={each.kind}>
            <Table.Th scope="row">{each.kind}</Table.Th>
            <Table.Td>{each.share > 1e-6 ? each.joint : "no bound is known"}</Table.Td>
            <Table.Td data-number>{percent(each.share, 1)}</Table.Td>
            <Table.Td data-number>{fixed(each.time, 2)}</Table.Td>
          </Table.Tr>
        ))}
      </WideTable>
      <Text size="xs" c="dimmed" mt={4}>
        A position counts from the middle of its range.
      </Text>
    </section>
  );
}
