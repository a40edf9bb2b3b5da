import { Anchor, Button, Group, List, Paper, Progress, Stack, Table, Text, Title } from "@mantine/core";

import { useAskPlan, usePlans, type Payload, type Plan, type What } from "../../api/payloads";
import { isActive } from "../../api/studies";
import { address } from "../../app/base";
import { figure, isNumber, percent, significant } from "../../parts/digits";
import { Loading } from "../../parts/Loading";
import { ForMembers } from "../../parts/ForMembers";
import { ProblemBox } from "../../parts/ProblemBox";
import { Said } from "../../parts/Said";
import { StateBadge } from "../../parts/StateBadge";
import { When } from "../../parts/When";
import { number, WideTable } from "../../parts/WideTable";
import { useCancel } from "../study/jobs";
import { duration } from "../study/words";
import { NAMES } from "./ValueTable";

const WORDS: Record<What, string> = { postures: "Postures", excitation: "Excitation" };

/** What to record: postures and motions within the limits of robot, sensor and cell. */
export function Plans({ payload }: { payload: Payload }) {
  const { data: plans, error, refetch } = usePlans(payload.id);
  const ask = useAskPlan(payload.id);
  return (
    <section aria-labelledby="plans">
      <Title order={2} size="h3" id="plans" mb="xs">
        What to record
      </Title>
      <Stack gap="sm">
        <Text size="sm" c="dimmed" style={{ maxWidth: "60rem" }}>
          Planned for the joints {payload.summary.plan?.joints.join(", ")}, within the limits of payload.yaml: each plan tells
          what standard deviation every number will have.
        </Text>
        <ForMembers told>
        <Group gap="sm">
          {(Object.keys(WORDS) as What[]).map((what) => (
            <Button key={what} variant="default" loading={ask.isPending && ask.variables === what} onClick={() => ask.mutate(what)}>
              Plan {WORDS[what].toLowerCase()}
            </Button>
          ))}
        </Group>
        </ForMembers>
        {ask.error && <ProblemBox error={ask.error} />}
        {error && !plans ? <ProblemBox error={error} retry={() => void refetch()} /> : !plans ? <Loading what="the plans" lines={1} /> : null}
        {plans?.map((plan) => (
          <PlanBox key={plan.job.id} plan={plan} />
        ))}
      </Stack>
    </section>
  );
}

export function PlanBox({ plan: { job, found, files } }: { plan: Plan }) {
  const cancel = useCancel(job.id);
  const what = WORDS[job.settings["what"] as What];
  return (
    <Paper withBorder p="md" component="article" aria-label={`${what}, planned`} data-plan={job.settings["what"] as string}>
      <Group justify="space-between">
        <Title order={3} size="h4">
          {what}
        </Title>
        <Group gap="xs">
          <StateBadge state={job.state} />
          <Text size="sm" c="dimmed">
            <When at={job.created_at} />
          </Text>
          {isActive(job.state) && (
            <ForMembers>
            <Button size="xs" variant="default" loading={cancel.isPending || job.cancel_requested} onClick={() => cancel.mutate()}>
              Cancel
            </Button>
            </ForMembers>
          )}
        </Group>
      </Group>
      {isActive(job.state) && (
        <>
          <Progress value={100 * job.progress} size="sm" my={6} aria-label={`Progress: ${what}`} />
          <Text size="sm" role="status">
            {job.state === "queued" ? `In the queue: ${job.place ?? "waiting"}.` : `${percent(job.progress)} ${job.message}`}
          </Text>
        </>
      )}
      {job.problem && <ProblemBox problem={job.problem} />}
      {job.state === "failed" && !job.problem && <Text size="sm">{job.reason}</Text>}
      {found && <Told found={found} />}
      {found && (
        <Group gap="md" mt="xs">
          {files.map((file) => (
            <Anchor key={file.name} size="sm" href={address(`api/v1/${file.href}`)} download>
              {file.name}
            </Anchor>
          ))}
        </Group>
      )}
    </Paper>
  );
}

function Told({ found }: { found: NonNullable<Plan["found"]> }) {
  const said = [`Takes ${duration(found.seconds)}.`];
  if (found.condition) said.push(`Condition ${figure(found.condition[0], 2)} (force) and ${figure(found.condition[1], 2)} (moment).`);
  if (isNumber(found.strain)) said.push(`Nearest bound: ${percent(found.strain, 1)} of it.`);
  if (found.undecided.length) said.push(`Stays open: ${found.undecided.join(", ")}.`);
  return (
    <>
      <Text size="sm" my="xs">
        {said.join(" ")}
      </Text>
      {found.warnings.length > 0 && (
        <List size="sm" mb="xs">
          {found.warnings.map((warning) => (
            <List.Item key={warning}>
              <Said words={warning} />
            </List.Item>
          ))}
        </List>
      )}
      <WideTable
        label={`Standard deviations: ${WORDS[found.kind]}`}
        columns={["Quantity", "Unit", number("std before"), number("std with this plan"), "Remark"]}
        mostHeight="20rem"
      >
        {found.certainties.map((each) => (
          <Table.Tr key={each.name}>
            <Table.Th scope="row">{NAMES[each.name] ?? each.name}</Table.Th>
            <Table.Td>{each.unit}</Table.Td>
            <Table.Td data-number>{significant(each.before, 2)}</Table.Td>
            <Table.Td data-number>{significant(each.std, 2)}</Table.Td>
            <Table.Td>{each.decided ? "" : "not decided"}</Table.Td>
          </Table.Tr>
        ))}
      </WideTable>
    </>
  );
}
