import { Anchor, Code, Stack, Text } from "@mantine/core";
import { Link } from "react-router";

import { answer, api } from "../../api/client";
import { usePayloads, type Payload } from "../../api/payloads";
import { Empty } from "../../parts/Empty";
import { ForMembers } from "../../parts/ForMembers";
import { LinkButton } from "../../parts/LinkButton";
import { PageTitle } from "../../parts/PageTitle";
import { Standing, ThingList, ThingRow } from "../../parts/ThingList";
import { useSought } from "../../parts/useSought";
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
  const payloads = usePayloads(sought.words);
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
      <Stack mt="xl">
        <ThingList
          things="payloads"
          pages={payloads}
          search={{ sought, placeholder: "Name of a payload", nothing: `No payload has “${sought.words}” in its name.` }}
          none={<NoPayloads />}
          row={(payload) => <PayloadRow key={payload.id} payload={payload} />}
        />
      </Stack>
    </>
  );
}

function PayloadRow({ payload }: { payload: Payload }) {
  const { id, name, latest_job: job, created_at, version } = payload;
  return (
    <ThingRow to={`/payloads/${id}`} name={name} facts={factsOf(payload).join(" · ")} job={job}>
      <Standing at={created_at} version={version} {...(identifies(payload) ? { job: job ?? null } : {})} />
    </ThingRow>
  );
}

function NoPayloads() {
  return (
      <Empty title="No payloads yet">
        <Text>
          Drop one above, or put one together from your own files, <Anchor component={Link} to="/payloads/new" inherit underline="always">step by step</Anchor>. To try with synthetic data, let <Code>exogauge sample --payload --seed 1 my-payload</Code> write
          one, and drop the folder <Code>my-payload</Code>.
        </Text>
      </Empty>
  );
}
