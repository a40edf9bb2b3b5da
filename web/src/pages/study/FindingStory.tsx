import { Alert, Anchor, Paper, Stack, Table, Text, Title } from "@mantine/core";
import { IconBulb } from "@tabler/icons-react";

import { address } from "../../app/base";
import { figure, percent, significant, unitOf } from "../../parts/digits";
import { Uncertain } from "../../parts/Uncertain";
import { number, WideTable } from "../../parts/WideTable";
import { CandidateTable } from "./CandidateTable";
import { EvidencePlot } from "./EvidencePlot";
import type { Finding, Measured } from "./results";
import { TakeOver } from "./TakeOver";
import { titleOf } from "./words";

const GREEK: Record<string, string> = { beta: "β", delta: "δ", mu: "μ", theta: "θ", tau: "τ" };

/** A named effect: the sentence, its evidence, its parameters, what it beat, and what it may still be. */
export function FindingStory({ finding, jobId }: { finding: Finding; jobId: string }) {
  const { held_out: held } = finding;
  const title = titleOf(finding);
  const key = `finding-${finding.rank}`;
  return (
    <Paper withBorder p="md" component="section" aria-labelledby={key}>
      <Title order={2} size="h3" id={key} mb={4}>
        {title}
      </Title>
      <Text mb="xs" style={{ maxWidth: "60rem" }}>
        {finding.evidence}
      </Text>
      <Text size="sm" c="dimmed" mb="sm">
        {held.channel_words ?? held.channel}, {held.log ? `${held.log} alone` : "held-out logs"}: {significant(held.rmse_before)} → {significant(held.rmse_after)} {held.unit} RMSE, noise
        floor {significant(held.noise_floor)}; it explains {percent(finding.score)} of the excess.
      </Text>
      <Stack gap="lg">
        {finding.curve.coordinate.values.length > 1 && (
          <EvidencePlot finding={finding} effect={finding.title ?? finding.effect} />
        )}
        <div style={{ maxWidth: "30rem" }}>
          <WideTable label={`Parameters of ${title}`} columns={["Parameter", number("Value ± std")]}>
          {Object.entries(finding.parameters).map(([name, value]) => (
            <Table.Tr key={name}>
              <Table.Th scope="row">
                <Letter name={name} />
                {finding.parameter_words?.[name] && (
                  <Text size="xs" c="dimmed" fw={400}>
                    {finding.parameter_words[name]}
                  </Text>
                )}
              </Table.Th>
              <Table.Td data-number>
                {value.std === 0 ? <Chosen {...value} /> : <Uncertain {...value} />}
              </Table.Td>
            </Table.Tr>
          ))}
          </WideTable>
        </div>
        {finding.taken_over && <TakeOver file={finding.taken_over} jobId={jobId} />}
        {finding.also_possible.length > 0 && (
          <Alert icon={<IconBulb aria-hidden />} color="yellow" variant="outline" title="These logs cannot tell it from">
            <CandidateTable name={`What may stand in for ${title}`} rows={finding.also_possible} />
            {finding.motion && (
              <Text size="sm" mt="xs">
                <strong>The motion that would tell:</strong> {finding.motion}
                {finding.planned?.map(({ file }) => (
                  <span key={file}>
                    {" "}
                    <Anchor inherit href={address(`api/v1/jobs/${jobId}/artifacts/${file}`)} download>
                      {file}
                    </Anchor>
                  </span>
                ))}
              </Text>
            )}
          </Alert>
        )}
        {finding.alternatives.length > 0 && (
          <div>
            <Title order={3} size="h5" mb={4}>
              What it was tried against
            </Title>
            <CandidateTable
              name={`Alternatives to ${title}`}
              rows={[{ ...finding, reason: "the one named" }, ...finding.alternatives]}
              chosen={0}
            />
          </div>
        )}
      </Stack>
    </Paper>
  );
}

/** A number that was tried among others, and not fitted. */
function Chosen({ value, unit }: Measured) {
  return (
    <>
      {figure(value)}
      {unitOf(unit) && `\u00a0${unitOf(unit)}`}
    </>
  );
}

/** `tau_b` as a letter with an index; longer names as words. */
function Letter({ name }: { name: string }) {
  const [, head = name, index = ""] = /^([^_]+)_?(.*)$/.exec(name) ?? [];
  const letter = GREEK[head] ?? head;
  if (letter.length > 2) return <>{name.replaceAll("_", " ")}</>;
  return (
    <>
      <i>{letter}</i>
      {index && <sub>{index}</sub>}
    </>
  );
}
