import { Stack, Text, Title } from "@mantine/core";

import { useMemo } from "react";

import { figure, significant } from "../../parts/digits";
import { Uncertain } from "../../parts/Uncertain";
import { BeforeAfter } from "./BeforeAfter";
import { ChannelErrors } from "./ChannelErrors";
import { ParameterTable } from "./ParameterTable";
import type { Results } from "./results";
import type { StudyLog } from "./summary";
import { SensorZeros } from "./SensorZeros";
import { SteadyTable } from "./SteadyTable";
import { Unknowns } from "./Unknowns";
import { POOLED } from "./words";

/** What the contact sensors weigh, against what the maker says. */
function TotalMass({ mass }: { mass: NonNullable<Results["identification"]["total_mass"]> }) {
  return (
    <Text size="sm" data-total-mass={mass.agrees ? "agrees" : "disagrees"}>
      The contact sensors weigh the robot to be <Uncertain value={mass.found_kg} std={mass.found_std_kg} unit="kg" />, its maker{" "}
      <Uncertain value={mass.stated_kg} std={mass.stated_std_kg} unit="kg" />: they {mass.agrees ? "agree" : "disagree"} (
      {significant(Math.abs(mass.z ?? 0), 2)} of {significant(mass.limit)} standard deviations).
    </Text>
  );
}

/** How well the identified robot explains its logs, its parameters, and what the logs cannot tell of them. */
export function IdentificationSection({ results, logs }: { results: Results; logs: StudyLog[] }) {
  const { identification: found, reading, doubt_sources } = results;
  const samples = useMemo(() => new Map(logs.map((log) => [log.name, log.samples])), [logs]);
  const heldOut = found.summary.some((each) => each.held_out);
  return (
    <Stack gap="xl">
      <section aria-labelledby="errors">
        <Title order={2} size="h3" id="errors">
          Error before and after
        </Title>
        <Text size="sm" c="dimmed" mb="sm">
          Root mean square error (RMSE) of the robot as its maker describes it and as identified, against what noise alone leaves,{" "}
          {heldOut ? "on logs that were not fitted" : "on the fitted logs: none was held out"}.
        </Text>
        <BeforeAfter
          name="Error before and after identification"
          rows={found.summary.map((each) => ({
            name: POOLED[each.kind] ?? each.kind,
            before: each.rmse_prior,
            after: each.rmse_identified,
            floor: each.noise_floor,
            unit: each.unit,
            sort: each.kind.startsWith("sensor_") ? "sensor" : "",
          }))}
        />
      </section>
      <ChannelErrors fits={found.validation} heldOut={heldOut} samples={samples} steadyWords={reading?.steady} />
      <SteadyTable shares={found.steady ?? []} words={reading?.steady_seconds} />
      <SensorZeros sensors={found.sensors ?? []} />
      <Unknowns found={found} />
      {found.total_mass && <TotalMass mass={found.total_mass} />}
      <ParameterTable parameters={found.parameters} sources={doubt_sources ?? []} />
      <Text size="sm" c="dimmed">
        From {found.samples.toLocaleString("en").replaceAll(",", "\u202f")} samples of steady motion, signals below{" "}
        {significant(found.cutoff_hz)} Hz. The logs tell {found.rank} sums of parameters (rank), with a condition number of{" "}
        {significant(found.condition)}; what was believed before weighs {figure(found.prior_strength)} times what it says.
      </Text>
    </Stack>
  );
}
