import { Alert, Anchor, List, Paper, SimpleGrid, Stack, Text, Title } from "@mantine/core";
import { Link, useSearchParams } from "react-router";

import type { Study } from "../../api/studies";
import { significant } from "../../parts/digits";
import { count } from "../../parts/size";
import { Uncertain } from "../../parts/Uncertain";
import type { Results } from "./results";
import type { SectionKey } from "./sections";
import { verdictOf } from "./verdict";
import { POOLED, STEPS } from "./words";

/** The findings on one screen; each leads to where it is told in full, if there is a study to lead to. */
export function SummarySection({ study, results }: { study?: Study; results: Results }) {
  const { identification, support, stiffness, discrepancy } = results;
  const main = support.filter((each) => each.main);
  const devices = [...new Set(support.map((each) => each.device))];
  const bands = stiffness
    .filter((each) => each.headline)
    .sort((one, other) => devices.indexOf(one.device) - devices.indexOf(other.device) || one.group.localeCompare(other.group));
  const groups = [...new Map(bands.map((each) => [`${each.device}, bands ${each.group}`, each])).entries()];
  const wrong = (results.notices ?? []).filter((each) => each.code === "doctor_errors");
  const skipped = results.steps.filter((each) => each.status === "skipped");
  return (
    <Stack gap="lg">
      {wrong.map((each) => (
        <Alert key={each.code} color="red" variant="light" style={{ maxWidth: "60rem" }}>
          {each.sentence}
        </Alert>
      ))}
      <Text size="lg" style={{ maxWidth: "60rem" }}>
        {discrepancy ? verdictOf(results) : `The robot ${results.robot} was identified from its own logs.`}
      </Text>
      <SimpleGrid cols={{ base: 1, md: 2 }} spacing="md">
        <Card study={study} to="identification" title="Identification">
          {identification.summary.map((each) => (
            <Fact key={each.kind} name={POOLED[each.kind] ?? each.kind} data={`summary-${each.kind}`}>
              {significant(each.rmse_prior)} → <strong>{significant(each.rmse_identified)}</strong> {each.unit} RMSE, noise{" "}
              {significant(each.noise_floor)}
            </Fact>
          ))}
          <Fact name="Told by the logs">
            {identification.parameters.length - identification.unidentifiable.length} of {count(identification.parameters.length, "parameter")}
          </Fact>
          <Note>
            RMSE, the root mean square error{identification.summary.some((each) => each.held_out) && ", on logs that were not fitted"}: by
            the maker’s values → as identified, and what noise alone makes.
          </Note>
        </Card>
        {discrepancy && (
          <Card study={study} to="disagreement" title="Disagreement">
            {discrepancy.findings.map((each) => (
              <Fact key={each.rank} name={each.held_out.channel_words ?? each.held_out.channel}>
                {significant(each.held_out.rmse_before)} → <strong>{significant(each.held_out.rmse_after)}</strong> {each.held_out.unit},
                noise {significant(each.held_out.noise_floor)}
              </Fact>
            ))}
            <Fact name="Still unexplained">
              {discrepancy.unexplained.map((each) => each.channel_words ?? each.channel).join(", ") || (discrepancy.left === "nothing" ? "nothing above the noise" : "cannot be judged")}
            </Fact>
            <Fact name="Tried">{count(discrepancy.candidates, "candidate")}</Fact>
          </Card>
        )}
        {main.length > 0 && (
          <Card study={study} to="support" title="Supporting torque, peak">
            {main.map((each) => (
              <Fact key={`${each.device} ${each.motion} ${each.joint}`} name={`${each.motion}, ${each.joint}`} about={each.device}>
                {each.peak && <Uncertain {...each.peak} />} {each.peak ? `by ${each.peak.approach}` : "not decided"}
              </Fact>
            ))}
            <Note>
              A: without minus with the device. B: model minus measurement. Paired: B with minus B without. The one that finds least where
              there is no device. ± is one standard deviation.
            </Note>
          </Card>
        )}
        {groups.length > 0 && (
          <Card study={study} to="stiffness" title="Stiffness of the bands">
            {groups.map(([name, each]) => (
              <Fact key={name} name={`Bands ${each.group}`} about={each.device}>
                <Uncertain {...each.stiffness_n_per_m} /> by {each.approach}
                {!each.identifiable && ", not decided"}
              </Fact>
            ))}
          </Card>
        )}
      </SimpleGrid>
      {(results.warnings.length > 0 || skipped.length > 0) && (
        <section aria-labelledby="mind">
          <Title order={2} size="h4" id="mind" mb="xs">
            To keep in mind
          </Title>
          <List size="sm" spacing={4} style={{ maxWidth: "70rem" }}>
            {skipped.map((each) => (
              <List.Item key={each.step}>
                {STEPS[each.step]?.[0] ?? each.step}: skipped, {each.reason}
              </List.Item>
            ))}
            {results.warnings.map((warning, k) => (
              <List.Item key={warning}>
                <Warning sentence={warning} notice={results.notices?.[k]} />
              </List.Item>
            ))}
          </List>
        </section>
      )}
    </Stack>
  );
}

function Card({ study, to, title, children }: { study?: Study; to: SectionKey; title: string; children: React.ReactNode }) {
  const [search] = useSearchParams();
  return (
    <Paper withBorder p="md" component="section">
      <Title order={2} size="h4" mb="xs">
        {study ? (
          <Anchor component={Link} inherit to={{ pathname: `/studies/${study.id}/${to}`, search: search.toString() }} preventScrollReset>
            {title}
          </Anchor>
        ) : (
          title
        )}
      </Title>
      <div>{children}</div>
    </Paper>
  );
}

function Note({ children }: { children: React.ReactNode }) {
  return (
    <Text component="div" size="xs" c="dimmed" mt="xs">
      {children}
    </Text>
  );
}

type FactProps = { name: string; about?: string; data?: string; children: React.ReactNode };

function Fact({ name, about, data, children }: FactProps) {
  return (
    <dl data-fact={data} style={{ display: "flex", flexWrap: "wrap", justifyContent: "space-between", gap: "0 1rem", margin: 0, padding: "0.2rem 0" }}>
      <Text component="dt" size="sm">
        {name}
        {about && (
          <Text span size="xs" c="dimmed">
            {" "}
            {about}
          </Text>
        )}
      </Text>
      <Text component="dd" size="sm" m={0} style={{ fontVariantNumeric: "tabular-nums" }}>
        {children}
      </Text>
    </dl>
  );
}

/** A long list of names is folded away behind the first few. */
function Warning({ sentence, notice }: { sentence: string; notice?: NonNullable<Results["notices"]>[number] }) {
  if (!notice?.short || notice.short === sentence) return sentence;
  return (
    <>
      {notice.short}
      <details>
        <summary>all {notice.names.length}</summary>
        {sentence}
      </details>
    </>
  );
}
