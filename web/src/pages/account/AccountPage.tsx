import { Button, Group, PasswordInput, Stack, Text, TextInput, Title } from "@mantine/core";
import { useState } from "react";

import { changePassword, createLab, signOutElsewhere, useArrive, useSession, type Session } from "../../api/session";
import { Empty } from "../../parts/Empty";
import { FactList } from "../../parts/FactList";
import { Loading } from "../../parts/Loading";
import { PageTitle } from "../../parts/PageTitle";
import { ProblemBox } from "../../parts/ProblemBox";
import { useDeed } from "../../parts/useDeed";
import { Logins } from "./Logins";
import { NewPassword } from "./NewPassword";
import { NoAccounts } from "./NoAccounts";
import { Tokens } from "./Tokens";

export function Component() {
  const { data: session, error, refetch } = useSession();
  if (error && !session) return <ProblemBox error={error} retry={() => void refetch()} />;
  if (!session) return <Loading what="the account" />;
  if (!session.account) return <NoAccounts />;
  const { account } = session;
  return (
    <Stack gap="xl">
      <div>
        <PageTitle title="Account" lead={account.email} />
        <FactList facts={[["Name", account.name], ["Labs", labsOf(session)]]} />
      </div>
      {session.lab ? <Tokens /> : <NoLab />}
      <Password />
      <Logins />
      <Elsewhere />
      {account.operator && <FoundLab />}
    </Stack>
  );
}

function labsOf({ labs }: Session) {
  return labs?.map((lab) => `${lab.name} (${lab.role})`).join(", ") || "none";
}

export function NoLab() {
  return (
    <Empty title="You are of no lab">
      <p>An admin of a lab can invite you, by the address of your account.</p>
    </Empty>
  );
}

function Password() {
  const { start, busy, error } = useDeed();
  const [current, setCurrent] = useState("");
  const [next, setNext] = useState("");
  const [done, setDone] = useState(false);
  const change = () =>
    start(async () => {
      setDone(false);
      await changePassword({ current, new: next });
      setCurrent("");
      setNext("");
      setDone(true);
    });
  return (
    <section aria-labelledby="password">
      <Title order={2} size="h3" id="password" mb="sm">
        Password
      </Title>
      <form onSubmit={(event) => { event.preventDefault(); change(); }}>
        <Stack maw="24rem" gap="sm">
          <PasswordInput
            label="Present password" autoComplete="current-password" required value={current}
            onChange={(event) => setCurrent(event.currentTarget.value)}
          />
          <NewPassword label="New password" value={next} onChange={setNext} />
          <Group>
            <Button type="submit" loading={busy}>
              Change it
            </Button>
            <Text role="status" size="sm">{done && "Changed. Other browsers were signed out."}</Text>
          </Group>
          {error !== null && <ProblemBox error={error} />}
        </Stack>
      </form>
    </section>
  );
}

function Elsewhere() {
  const { start, busy, error } = useDeed();
  const [done, setDone] = useState(false);
  return (
    <section aria-labelledby="elsewhere">
      <Title order={2} size="h3" id="elsewhere" mb="sm">
        Other browsers
      </Title>
      <Group>
        <Button variant="default" loading={busy} onClick={() => start(async () => { await signOutElsewhere(); setDone(true); })}>
          Sign out everywhere else
        </Button>
        <Text role="status" size="sm">{done && "Only this browser is signed in now."}</Text>
      </Group>
      {error !== null && <ProblemBox error={error} />}
    </section>
  );
}

function FoundLab() {
  const { start, busy, error } = useDeed();
  const arrive = useArrive();
  const [name, setName] = useState("");
  return (
    <section aria-labelledby="found">
      <Title order={2} size="h3" id="found" mb="sm">
        Another lab
      </Title>
      <form onSubmit={(event) => { event.preventDefault(); start(async () => { await createLab(name); await arrive("/lab"); }); }}>
        <Group align="flex-end">
          <TextInput label="Its name" required value={name} onChange={(event) => setName(event.currentTarget.value)} />
          <Button type="submit" variant="default" loading={busy}>
            Found it
          </Button>
        </Group>
      </form>
      {error !== null && <ProblemBox error={error} />}
    </section>
  );
}
