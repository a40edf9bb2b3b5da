import { Box, Table, Text, Title } from "@mantine/core";

import type { Found } from "../../api/motions";
import { FactList } from "../../parts/FactList";
import { fixed, isNumber, NONE, percent } from "../../parts/digits";
import { number, WideTable } from "../../parts/WideTable";

type Left = Found["margins"];

const PRESSURE = "Centre of pressure";

/** What is left of balance and distances, and which bounds bind; beside it, of the same motion frame by frame. */
export function Margins({ found }: { found: Found }) {
  const { margins, frame_by_frame: alone } = found;
  const [nearest] = margins.bounds;
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
      {alone ? (
        <WideTable label="Balance and distances" columns={["What is left", "Planned", "Frame by frame"]}>
          {left(margins).map(([what, planned], k) => (
            <Table.Tr key={what}>
              <Table.Th scope="row">{what}</Table.Th>
              <Table.Td>{planned}</Table.Td>
              <Table.Td>
                {left(alone.margins)[k]?.[1]}
                {what === PRESSURE && alone.outside > 0 && `; outside in ${percent(alone.outside, 1)} of samples`}
              </Table.Td>
            </Table.Tr>
          ))}
          <Table.Tr>
            <Table.Th scope="row">Bounds broken</Table.Th>
            <Table.Td>{found.broken.length || "none"}</Table.Td>
            <Table.Td>{alone.broken.length || "none"}</Table.Td>
          </Table.Tr>
        </WideTable>
      ) : (
        <Box mb="sm">
          <FactList facts={left(margins)} />
        </Box>
      )}
      {alone && (
        <Text size="xs" c="dimmed" mt={4} mb="md">
          Frame by frame: each posture by itself, feet first, then smoothed as the plan is. It is what a motion without a plan would be, and is not exported.
        </Text>
      )}
      <WideTable
        label="Bounds"
        columns={["Bound", "Joint that comes nearest", number("share of it"), number("at", "s"), ...(alone ? [number("frame by frame, share of it")] : [])]}
      >
        {margins.bounds.map((each) => (
          <Table.Tr key={each.kind} data-bound={each.kind}>
            <Table.Th scope="row">{each.kind}</Table.Th>
            <Table.Td>{each.share > 1e-6 ? each.joint : "no bound is known"}</Table.Td>
            <Table.Td data-number>{each.share > 1e-6 ? percent(each.share, 1) : NONE}</Table.Td>
            <Table.Td data-number>{each.share > 1e-6 ? fixed(each.time, 2) : NONE}</Table.Td>
            {alone && <Table.Td data-number>{percent(shareOf(alone.margins, each.kind), 1)}</Table.Td>}
          </Table.Tr>
        ))}
      </WideTable>
      <Text size="xs" c="dimmed" mt={4}>
        A position counts from the middle of its range.
      </Text>
    </section>
  );
}

/** In the same order, and the same rows, of every motion of one robot. */
function left(margins: Left): [string, React.ReactNode][] {
  const facts: [string, React.ReactNode][] = [];
  if (isNumber(margins.pressure_inside_m)) {
    const inside = margins.pressure_inside_m;
    facts.push([PRESSURE, `${fixed(1e3 * Math.abs(inside), 1)} mm ${inside < 0 ? "outside what the feet stand on, at most" : "inside what the feet stand on, at least"}`]);
  }
  if (isNumber(margins.weight_carried)) facts.push(["Weight on the feet", `${percent(margins.weight_carried)} at least`]);
  if (isNumber(margins.feet_m) && isNumber(margins.feet_rad)) facts.push(["Feet", `move by ${fixed(1e3 * margins.feet_m, 3)} mm and ${fixed((180 / Math.PI) * margins.feet_rad, 4)}° at most`]);
  if (isNumber(margins.apart_m)) {
    const where = margins.nearest ? `: ${margins.nearest.links.join(" and ")} at ${fixed(margins.nearest.time, 2)} s` : " or more";
    const deep = margins.apart_m < 0 ? " into each other" : "";
    facts.push(["Nearest pair", `${fixed(1e3 * Math.abs(margins.apart_m), 1)} mm${deep}${where}`]);
  }
  return facts;
}

function shareOf({ bounds }: Left, kind: string): number {
  return bounds.find((each) => each.kind === kind)?.share ?? 0;
}
