import { Alert, List, Stack, Text, Title } from "@mantine/core";

import type { Payload, PayloadResults } from "../../api/payloads";
import { plusMinus, significant } from "../../parts/digits";
import { Said } from "../../parts/Said";
import { Calibration } from "./Calibration";
import { Contacts } from "./Contacts";
import { Missing } from "./Missing";
import { Remainders } from "./Remainders";
import { ValueTable } from "./ValueTable";

/** What was identified, how surely, and what is left of the wrench. */
export function Results({ payload, results }: { payload: Payload; results: PayloadResults }) {
  return (
    <>
      <section aria-labelledby="found">
        <Title order={2} size="h3" id="found" mb="xs">
          What was identified
        </Title>
        <Stack gap="xs">
          <Text style={{ maxWidth: "60rem" }}>{sentences(results).join(" ")}</Text>
          {results.warnings.length > 0 && (
            <Alert color="orange" variant="default" title="Read with care">
              <List size="sm">
                {results.warnings.map((warning) => (
                  <List.Item key={warning}>
                    <Said words={warning} />
                  </List.Item>
                ))}
              </List>
            </Alert>
          )}
          <ValueTable payload={payload} results={results} />
        </Stack>
      </section>
      <Remainders payload={payload} results={results} />
      <Calibration results={results} />
      <Missing missing={results.missing ?? null} />
      <Contacts results={results} />
    </>
  );
}

function sentences({ static: still, dynamic: moved, mass_error_kg, frame, imu }: PayloadResults): string[] {
  const said = [];
  const mass = (moved?.values ?? still?.values ?? []).find(({ name }) => name === "m");
  if (mass) said.push(`${plusMinus(mass.value, mass.std)} kg; vectors in the ${frame}.`);
  if (mass_error_kg !== null) said.push(`Against the weighed mass: ${plusMinus(1000 * mass_error_kg, mass ? 1000 * mass.std : null)} g.`);
  if (still) {
    const [level, inclined] = [still.left_out_level, still.left_out_inclined].map((each) => (each ? `${significant(each.force_n, 2)} N` : "cannot be told"));
    said.push(`${still.postures} postures; error in one that was left out: base level ${level}, inclined ${inclined}; the inclination was ${still.inclined ? "taken" : "left out"}.`);
  }
  if (moved && moved.mu !== null) {
    said.push(`Residual over what the stated noise explains: ${plusMinus(moved.mu, moved.mu_std)}.`);
    said.push(moved.least_squares_would_do ? "LS would have done." : "LS differs by more than its scatter.");
  }
  if (moved?.possible) said.push(`No body has all of these values; the likeliest one that can exist costs χ² = ${significant(moved.cost_of_possible, 2)}, and is what is exported.`);
  if (imu) said.push(`IMU: ${significant(imu.angle_deg)}° off the sensor’s axes, ${significant(imu.lag_ms)} ms late.`);
  return said;
}
