import { Button, Group, NativeSelect, Stack, Text, TextInput, Title } from "@mantine/core";
import { useState } from "react";

import { useInvitations, useLabDeeds, type Invitation } from "../../api/lab";
import type { Role } from "../../api/session";
import { address } from "../../app/base";
import { Loading } from "../../parts/Loading";
import { ProblemBox } from "../../parts/ProblemBox";
import { AtRight, Row, Rows } from "../../parts/Rows";
import { ShownOnce } from "../../parts/ShownOnce";
import { useDeed } from "../../parts/useDeed";
import { When } from "../../parts/When";
import { ROLES } from "./roles";

export function Invitations() {
  const { data, error, refetch } = useInvitations(true);
  const { invite } = useLabDeeds();
  const { start, busy, error: refused } = useDeed();
  const [email, setEmail] = useState("");
  const [role, setRole] = useState<Role>("member");
  const [link, setLink] = useState<{ to: string; url: string } | null>(null);
  const send = () =>
    start(async () => {
      const { code, invitation } = await invite(email.trim(), role);
      setLink({ to: invitation.email, url: `${address("invited")}#${code}` });
      setEmail("");
    });
  return (
    <Stack component="section" aria-labelledby="invitations" gap="sm">
      <Title order={2} size="h3" id="invitations">
        Invitations
      </Title>
      <Text size="sm" c="dimmed">
        Nothing is sent: hand the link over yourself. It is good once, for a week, for this address.
      </Text>
      <form onSubmit={(event) => { event.preventDefault(); send(); }}>
        <Group align="flex-end" gap="sm">
          <TextInput label="E-mail address" type="email" required value={email} onChange={(event) => setEmail(event.currentTarget.value)} />
          <NativeSelect label="As" data={ROLES} value={role} onChange={(event) => setRole(event.currentTarget.value as Role)} />
          <Button type="submit" loading={busy}>
            Invite
          </Button>
        </Group>
      </form>
      {refused !== null && <ProblemBox error={refused} />}
      {link && <ShownOnce title={`The link for ${link.to}`} secret={link.url} onDone={() => setLink(null)} />}
      {error && !data ? (
        <ProblemBox error={error} retry={() => void refetch()} />
      ) : data ? (
        <Rows>
          {data.items.map((each) => (
            <InvitationRow key={each.id} invitation={each} />
          ))}
        </Rows>
      ) : (
        <Loading what="the invitations" />
      )}
    </Stack>
  );
}

function InvitationRow({ invitation }: { invitation: Invitation }) {
  const { withdraw } = useLabDeeds();
  const { start, busy, error } = useDeed();
  const ended = stateOf(invitation);
  const words = (
    <>
      <Text fw={600}>{invitation.email}</Text>
      <Text size="sm" c="dimmed">
        as {invitation.role}, <When at={invitation.created_at} />
      </Text>
      {error !== null && <ProblemBox error={error} />}
    </>
  );
  return (
    <Row words={words}>
      {ended ? (
        <AtRight>{ended}</AtRight>
      ) : (
        <Button variant="default" loading={busy} onClick={() => start(async () => void (await withdraw(invitation.id)))}>
          Withdraw {invitation.email}
        </Button>
      )}
    </Row>
  );
}

function stateOf({ accepted_at, revoked_at, expires_at }: Invitation): string | null {
  if (accepted_at) return "accepted";
  if (revoked_at) return "withdrawn";
  return new Date(expires_at) < new Date() ? "run out" : null;
}
