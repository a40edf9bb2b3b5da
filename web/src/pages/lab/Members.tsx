import { Button, Group, NativeSelect, Stack, Text, Title } from "@mantine/core";

import { useState } from "react";

import { useLabDeeds, useMembers, type Member } from "../../api/lab";
import { useSession, type Role } from "../../api/session";
import { Loading } from "../../parts/Loading";
import { ProblemBox } from "../../parts/ProblemBox";
import { AtRight, Row, Rows } from "../../parts/Rows";
import { useDeed } from "../../parts/useDeed";
import { ROLES } from "./roles";

export function Members({ admin }: { admin: boolean }) {
  const { data, error, refetch } = useMembers();
  if (error && !data) return <ProblemBox error={error} retry={() => void refetch()} />;
  if (!data) return <Loading what="the members" />;
  return (
    <Stack component="section" aria-labelledby="members" gap="sm">
      <Title order={2} size="h3" id="members">
        Members
      </Title>
      <Rows>
        {data.items.map((member) => (
          <MemberRow key={member.account_id} member={member} admin={admin} />
        ))}
      </Rows>
    </Stack>
  );
}

function MemberRow({ member, admin }: { member: Member; admin: boolean }) {
  const { data: session } = useSession();
  const { setRole, remove } = useLabDeeds();
  const { start, busy, error } = useDeed();
  const [asking, setAsking] = useState(false);
  const me = session?.account?.id === member.account_id;
  const words = (
    <>
      <Text fw={600}>
        {member.name}
        {me && " (you)"}
      </Text>
      <Text size="sm" c="dimmed">
        {member.email}
        {member.disabled_at && " · locked"}
      </Text>
      {error !== null && <ProblemBox error={error} />}
    </>
  );
  return (
    <Row words={words}>
      {admin ? (
        <Group gap="xs">
          <NativeSelect
            aria-label={`Role of ${member.name}`} data={ROLES} value={member.role} disabled={busy}
            onChange={(event) => {
              const role = event.currentTarget.value as Role;
              start(async () => void (await setRole(member.account_id, role)));
            }}
          />
          {asking ? (
            <>
              <Button variant="default" onClick={() => setAsking(false)}>
                Keep {member.name}
              </Button>
              <Button color="red" loading={busy} onClick={() => start(async () => void (await remove(member.account_id)))}>
                Remove, with its tokens
              </Button>
            </>
          ) : (
            <Button variant="default" onClick={() => setAsking(true)}>
              Remove {member.name}
            </Button>
          )}
        </Group>
      ) : (
        <AtRight>{member.role}</AtRight>
      )}
    </Row>
  );
}
