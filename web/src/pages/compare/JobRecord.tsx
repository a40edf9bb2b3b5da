import { Anchor, Code, Stack, Table, Text, Title } from "@mantine/core";
import { Link } from "react-router";

import type { Comparison } from "../../api/compare";
import { address } from "../../app/base";
import { When } from "../../parts/When";
import { WideTable } from "../../parts/WideTable";
import { jobNames } from "./heads";

/** Which evaluations these are, so that a printed page can be followed back. */
export function JobRecord({ comparison }: { comparison: Comparison }) {
  const names = jobNames(comparison);
  return (
    <Stack component="section" gap="sm" aria-labelledby="record">
      <Title order={2} size="h3" id="record">
        Where it comes from
      </Title>
      <WideTable
        label="Where it comes from"
        tight
        columns={["Study", "Robot", "Job", "Asked for", "Code", "To read and print"]}
      >
        {comparison.jobs.map((job, k) => (
          <Table.Tr key={job.id}>
            <Table.Th scope="row">
              <Anchor component={Link} to={`/studies/${job.study_id}`} size="sm">
                {names[k]}
              </Anchor>
            </Table.Th>
            <Table.Td>{job.robot}</Table.Td>
            <Table.Td>
              <Code>{job.id}</Code>
            </Table.Td>
            <Table.Td>
              <When at={job.created_at} />
            </Table.Td>
            <Table.Td>{job.code_version}</Table.Td>
            <Table.Td>
              <Anchor href={address(`api/v1/jobs/${job.id}/artifacts/report.html`)} size="sm" target="_blank">
                Report of {names[k]}
              </Anchor>
            </Table.Td>
          </Table.Tr>
        ))}
      </WideTable>
      <Text size="sm" c="dimmed">
        These figures hold for the robots, devices and motions named here, as they were recorded; they say nothing of others.
      </Text>
    </Stack>
  );
}
