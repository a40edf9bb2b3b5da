import { List, Stack, Table, Text, Title } from "@mantine/core";

import type { Study } from "../../api/studies";
import { isNumber, NONE, significant } from "../../parts/digits";
import { Uncertain } from "../../parts/Uncertain";
import { numbers, WideTable } from "../../parts/WideTable";
import { CandidateTable } from "./CandidateTable";
import { Chain } from "./Chain";
import { FindingStory } from "./FindingStory";
import type { Job } from "./jobs";
import type { Discrepancy, Excess, Measured, Results } from "./results";
import { Skipped } from "./Skipped";
import { counted, leftOf, verdictOf } from "./verdict";
import { count } from "../../parts/size";
import { Versions } from "./Versions";
import { capital } from "./words";

/** From the first gap to the noise floor: what was missing, why that is believed, what it was not, what is left. */
export function DisagreementSection({ study, job, results }: { study: Study; job: Job; results: Results }) {
  const found = results.discrepancy;
  if (!found)
    return <Skipped results={results} step="discrepancy" advice="It needs a log that is not fitted: role validation or without_device." />;
  return (
    <Stack gap="xl">
      <div>
        <Title order={2} size="h3" mb={4}>
          What the model lacked
        </Title>
        <Text size="lg" style={{ maxWidth: "60rem" }} data-testid="verdict">
          {verdictOf(results)}
        </Text>
        <Text size="sm" c="dimmed" mt={4}>
          {counted(found.candidates)} candidates were tried, each an effect at one place in one shape, fitted together with the whole
          model and judged on held-out logs in steady motion.
        </Text>
      </div>
      {found.chain.length > 0 && (
        <Chain id="chain" title="From the first gap to the noise floor" chain={found.chain} />
      )}
      {found.wear_chain && found.wear_chain.length > 0 && (
        <Chain id="wear-chain" title="The model of the wear, down to the noise floor" chain={found.wear_chain} />
      )}
      {found.findings.map((each) => (
        <FindingStory key={each.rank} finding={each} jobId={job.id} />
      ))}
      <section aria-labelledby="left">
        <Title order={2} size="h3" id="left" mb={4}>
          What is left
        </Title>
        <Text size="sm">{leftOf(found)}</Text>
        {found.unexplained.length > 0 && <Excesses name="Channels above their noise with all that was named" rows={found.unexplained} />}
        {found.within_declared && found.within_declared.length > 0 && (
          <Excesses name="Channels above their noise, no further than declared uncertainties let them" rows={found.within_declared} />
        )}
        {found.located.length > 0 && (
          <>
            <Title order={3} size="h5" mt="md" mb={4}>
              Where the first model disagreed
            </Title>
            <Excesses name="Channels above their noise before anything was named" rows={found.located} />
          </>
        )}
      </section>
      {found.rejected.length > 0 && (
        <section aria-labelledby="rejected">
          <Title order={2} size="h3" id="rejected" mb={4}>
            Tried and not named
          </Title>
          <CandidateTable name="Candidates that were not named" rows={found.rejected} />
        </section>
      )}
      <Consequences found={found} />
      <Versions study={study} job={job} results={results} found={found} />
      {found.notes.length > 0 && (
        <List size="sm">
          {[...new Set(found.notes)].map((note) => (
            <List.Item key={note}>{note}</List.Item>
          ))}
        </List>
      )}
    </Stack>
  );
}

function Excesses({ name, rows }: { name: string; rows: Excess[] }) {
  return (
    <WideTable label={name} columns={["Channel", ...numbers("RMSE", "Noise floor", "Standard errors above"), "Where"]}>
      {rows.map((each) => (
        <Table.Tr key={each.channel}>
          <Table.Th scope="row">{each.channel_words ?? each.channel}</Table.Th>
          <Table.Td data-number>
            {significant(each.rmse)} {each.unit}
          </Table.Td>
          <Table.Td data-number>
            {significant(each.noise_floor)} {each.unit}
          </Table.Td>
          <Table.Td data-number>{significant(each.z, 2)}</Table.Td>
          <Table.Td>{each.where}</Table.Td>
        </Table.Tr>
      ))}
    </WideTable>
  );
}

/** What the named effects change of support and stiffness. */
function Consequences({ found }: { found: Discrepancy }) {
  const rows = Object.entries(found.before_after);
  if (!rows.length) return null;
  const moved = rows.filter(([, { moves }]) => moves !== false);
  const others = rows.filter(([, { moves }]) => moves === false);
  return (
    <section aria-labelledby="consequences">
      <Title order={2} size="h3" id="consequences" mb={4}>
        What that changes
      </Title>
      {moved.length > 0 && <Changes label="Support and stiffness without and with the named effects" rows={moved} />}
      {others.length > 0 && (
        <details style={{ marginTop: "0.5rem", fontSize: "var(--mantine-font-size-sm)" }}>
          <summary>{count(others.length, "quantity stays", "quantities stay")} as they were</summary>
          <Changes label="What the named effects do not change" rows={others} />
        </details>
      )}
    </section>
  );
}

function Changes({ label, rows }: { label: string; rows: [string, { before: Measured; after: Measured }][] }) {
  return (
    <WideTable label={label} columns={["Quantity", ...numbers("Without", "With", "Change")]}>
      {rows.map(([quantity, { before, after }]) => (
        <Table.Tr key={quantity}>
          <Table.Th scope="row">{capital(quantity)}</Table.Th>
          <Table.Td data-number>
            <Uncertain {...before} />
          </Table.Td>
          <Table.Td data-number>
            <Uncertain {...after} />
          </Table.Td>
          <Table.Td data-number>{changeOf(before, after)}</Table.Td>
        </Table.Tr>
      ))}
    </WideTable>
  );
}

function changeOf(before: Measured, after: Measured): string {
  if (!isNumber(before.value) || !isNumber(after.value) || before.value === 0) return NONE;
  const percent = Math.round(100 * (Math.abs(after.value) / Math.abs(before.value) - 1));
  return `${percent > 0 ? "+" : percent < 0 ? "−" : ""}${Math.abs(percent)} %`;
}
