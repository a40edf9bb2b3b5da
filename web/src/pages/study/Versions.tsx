import { Table, Text, Title } from "@mantine/core";

import type { Study } from "../../api/studies";
import { WideTable } from "../../parts/WideTable";
import { When } from "../../parts/When";
import { count } from "../../parts/size";
import type { Job } from "./jobs";
import type { Discrepancy, Finding, Results } from "./results";
import { summaryOf } from "./summary";

const LISTED = 4;

type Props = { study: Study; job: Job; results: Results; found: Discrepancy };

/** Which model came from which: what was added and where, from which logs, and when. */
export function Versions({ study, job, results, found }: Props) {
  if (found.lineage.length < 2) return null;
  const { validation } = results.identification;
  const fitted = namesOf(validation.filter((fit) => !fit.held_out));
  const judged = namesOf(validation.filter((fit) => fit.held_out));
  const worn = (summaryOf(study).logs ?? []).filter((log) => log.role === "with_device").map((log) => log.name);
  const rows = found.lineage.map((each) => {
    const finding = found.findings.find(({ rank }) => rank === each.finding);
    return { ...each, finding, logs: finding && isOfWear(finding) ? worn : judged };
  });
  return (
    <section aria-labelledby="lineage">
      <Title order={2} size="h3" id="lineage" mb={4}>
        Versions of the model
      </Title>
      <Text size="sm" c="dimmed" mb="xs">
        Made <When at={job.finished_at ?? job.created_at} />. Each is the one above it with one effect more, fitted anew.
      </Text>
      <WideTable label="Versions of the model" columns={["Version", "What was added", "From which logs", "Identifier"]}>
        {rows.map(({ version, added, title, finding, logs }, k) => (
          <Table.Tr key={version}>
            <Table.Td>{k + 1}</Table.Td>
            <Table.Th scope="row">{k === 0 ? "Nothing: the robot as identified" : (title ?? added)}</Table.Th>
            <Table.Td>
              {k === 0 ? (
                <>
                  fitted to <Logs names={fitted} />
                </>
              ) : (
                <>
                  judged on <Logs names={finding?.held_out.log ? [finding.held_out.log] : logs} />
                </>
              )}
            </Table.Td>
            <Table.Td>
              <Text component="code" size="xs" c="dimmed" style={{ overflowWrap: "anywhere" }}>
                {k === 0 ? version : `+ ${added}`}
              </Text>
            </Table.Td>
          </Table.Tr>
        ))}
      </WideTable>
    </section>
  );
}

function Logs({ names }: { names: string[] }) {
  const more = names.length - LISTED;
  if (more <= 1) return <>{names.join(", ")}</>;
  return (
    <span title={names.join(", ")}>
      {names.slice(0, LISTED).join(", ")} and {count(more, "log")} more
    </span>
  );
}

function namesOf(fits: { log: string }[]): string[] {
  return [...new Set(fits.map((fit) => fit.log))];
}

function isOfWear({ where }: Finding): boolean {
  return "band" in where || "device" in where;
}
