import { Anchor, Button, Code, Group, Stack, Text, Title } from "@mantine/core";
import { Link } from "react-router";

import { answer, api } from "../../api/client";
import { usePayloads, type Payload } from "../../api/payloads";
import { Empty } from "../../parts/Empty";
import { LinkButton } from "../../parts/LinkButton";
import { Loading } from "../../parts/Loading";
import { PageTitle } from "../../parts/PageTitle";
import { ForMembers } from "../../parts/ForMembers";
import { ProblemBox } from "../../parts/ProblemBox";
import { AtRight, Row, Rows } from "../../parts/Rows";
import { NothingFound, SearchBox } from "../../parts/SearchBox";
import { StateBadge } from "../../parts/StateBadge";
import { useSought, type Sought } from "../../parts/useSought";
import { When } from "../../parts/When";
import type { HandedIn } from "../studies/handedIn";
import { HandIn } from "../studies/HandIn";
import { factsOf, identifies } from "./facts";

const PAYLOAD: HandedIn = {
  main: "payload.yaml",
  list: "payloads",
  keep: (body, signal) => answer(api.POST("/api/v1/payloads/from-upload", { body, signal })),
  job: (kept) => (identifies(kept as Payload) ? { payload_id: kept.id, kind: "payload", settings: {} } : null),
};

export function Component() {
  const sought = useSought();
  const { data: payloads, error, refetch, hasNextPage, fetchNextPage, isFetchingNextPage } = usePayloads(sought.words);
  return (
    <>
      <PageTitle title="Payloads" lead="What hangs on a wrist force/torque sensor: mass, centre, inertia, and what touches it.">
        <ForMembers>
          <LinkButton to="/payloads/new">New payload, step by step</LinkButton>
        </ForMembers>
      </PageTitle>
      <HandIn of={PAYLOAD} title="Drop a payload here" atOnce="Identify at once">
        One zip, a folder, or its files: <code>payload.yaml</code>, the logs and, where the pose is from joint angles, the URDF.
        With <code>plan</code> in payload.yaml no log is needed.
      </HandIn>
      {error && !payloads ? (
        <ProblemBox error={error} retry={() => void refetch()} />
      ) : !payloads ? (
        <Loading what="the payloads" />
      ) : payloads.length === 0 && !sought.words ? (
        <NoPayloads />
      ) : (
        <Stack gap="sm" mt="xl">
          <PayloadList payloads={payloads} sought={sought} />
          {hasNextPage && (
            <Button variant="default" onClick={() => void fetchNextPage()} loading={isFetchingNextPage} mx="auto">
              Show older payloads
            </Button>
          )}
        </Stack>
      )}
    </>
  );
}

function PayloadList({ payloads, sought }: { payloads: Payload[]; sought: Sought }) {
  return (
    <section aria-labelledby="payloads">
      <Group justify="space-between" align="flex-end" mb="sm">
        <Title order={2} size="h3" id="payloads">
          Handed in
        </Title>
        <SearchBox what="payloads" placeholder="Name of a payload" sought={sought} />
      </Group>
      {payloads.length === 0 && <NothingFound sentence={`No payload has “${sought.words}” in its name.`} clear={sought.clear} />}
      <Rows>
        {payloads.map((payload) => (
          <PayloadRow key={payload.id} payload={payload} />
        ))}
      </Rows>
    </section>
  );
}

function PayloadRow({ payload }: { payload: Payload }) {
  const job = payload.latest_job;
  const words = (
    <>
      <Anchor component={Link} to={`/payloads/${payload.id}`} fw={600}>
        {payload.name}
      </Anchor>
      <Text size="sm" c="dimmed">
        {factsOf(payload).join(" · ")}
      </Text>
      {job?.state === "failed" && job.reason && (
        <Text size="sm" lineClamp={2}>
          {job.reason}
        </Text>
      )}
    </>
  );
  return (
    <Row words={words}>
      {identifies(payload) && <StateBadge state={job?.state} />}
      <AtRight>
        version {payload.version}
        <br />
        <When at={payload.created_at} />
      </AtRight>
    </Row>
  );
}

function NoPayloads() {
  return (
    <Stack mt="xl">
      <Empty title="No payloads yet">
        <Text>
          Drop one above, or put one together from your own files, <Anchor component={Link} to="/payloads/new" inherit underline="always">step by step</Anchor>. To try with synthetic data, let <Code>exogauge sample --payload --seed 1 my-payload</Code> write
          one, and drop the folder <Code>my-payload</Code>.
        </Text>
      </Empty>
    </Stack>
  );
}
