import { Button, Checkbox, Group, NativeSelect, Stack, Table, Text, TextInput, Title } from "@mantine/core";
import { useState } from "react";

import { useLabDeeds, useTokens, type Token } from "../../api/lab";
import { useSession } from "../../api/session";
import { Loading } from "../../parts/Loading";
import { ProblemBox } from "../../parts/ProblemBox";
import { ShownOnce } from "../../parts/ShownOnce";
import { useDeed } from "../../parts/useDeed";
import { WideTable } from "../../parts/WideTable";
import { When } from "../../parts/When";

const DAYS = [
  { value: "30", label: "30 days" },
  { value: "90", label: "90 days" },
  { value: "365", label: "a year" },
  { value: "", label: "no end" },
];

/** Programs that may come in, in the lab that is shown: one's own, and to an admin those of all. */
export function Tokens() {
  const { data: session } = useSession();
  const { data, error, refetch } = useTokens();
  const { makeToken } = useLabDeeds();
  const { start, busy, error: refused } = useDeed();
  const [made, setMade] = useState<string | null>(null);
  const [name, setName] = useState("");
  const [scope, setScope] = useState<"read" | "write">("read");
  const [days, setDays] = useState("90");
  const [robot, setRobot] = useState(false);
  const role = session?.lab?.role;
  const make = () =>
    start(async () => {
      const { secret } = await makeToken({ name, scope, robot, days: days ? Number(days) : null });
      setMade(secret);
      setName("");
    });
  return (
    <Stack component="section" aria-labelledby="tokens" gap="sm">
      <Title order={2} size="h3" id="tokens">
        Tokens
      </Title>
      <Text size="sm" c="dimmed">
        For programs, in the lab {session?.lab?.name}: <code>Authorization: Bearer …</code>, or <code>EXOGAUGE_TOKEN</code> for the
        client and the commands. A token may no more than its owner, and administers nothing.
      </Text>
      <form onSubmit={(event) => { event.preventDefault(); make(); }}>
        <Group align="flex-end" gap="sm">
          <TextInput label="Name" placeholder="what it is for" required value={name} onChange={(event) => setName(event.currentTarget.value)} />
          <NativeSelect
            label="It may" value={scope} onChange={(event) => setScope(event.currentTarget.value as "read" | "write")}
            data={[{ value: "read", label: "read" }, ...(role === "viewer" ? [] : [{ value: "write", label: "read and write" }])]}
          />
          <NativeSelect label="For" data={DAYS} value={days} onChange={(event) => setDays(event.currentTarget.value)} />
          {role === "admin" && (
            <Checkbox
              label="Robot: the lab’s, stays when you leave" checked={robot} mb={8}
              onChange={(event) => setRobot(event.currentTarget.checked)}
            />
          )}
          <Button type="submit" loading={busy}>
            Make a token
          </Button>
        </Group>
      </form>
      {refused !== null && <ProblemBox error={refused} />}
      {made && <ShownOnce title="The new token" secret={made} onDone={() => setMade(null)} />}
      {error && !data ? <ProblemBox error={error} retry={() => void refetch()} /> : data ? <List tokens={data.items} /> : <Loading what="the tokens" />}
    </Stack>
  );
}

function List({ tokens }: { tokens: Token[] }) {
  if (tokens.length === 0) return <Text c="dimmed">No tokens yet.</Text>;
  return (
    <WideTable label="Tokens" columns={["Name", "Begins with", "Whose", "May", "Last used", "Ends", "Now"]}>
      {tokens.map((token) => (
        <Row key={token.id} token={token} />
      ))}
    </WideTable>
  );
}

function Row({ token }: { token: Token }) {
  const { revokeToken } = useLabDeeds();
  const { start, busy, error } = useDeed();
  const over = token.revoked_at ? "revoked" : token.expires_at && new Date(token.expires_at) < new Date() ? "ended" : null;
  return (
    <Table.Tr>
      <Table.Th scope="row">{token.name}</Table.Th>
      <Table.Td>
        <code>{token.hint}</code>
      </Table.Td>
      <Table.Td>{token.robot ? "robot" : (token.owner ?? "of one who left")}</Table.Td>
      <Table.Td>{token.scope === "write" ? "read and write" : "read"}</Table.Td>
      <Table.Td>{token.used_at ? <When at={token.used_at} /> : "never"}</Table.Td>
      <Table.Td>{token.expires_at ? <When at={token.expires_at} /> : "never"}</Table.Td>
      <Table.Td>
        {over ?? (
          <Button size="compact-sm" variant="default" loading={busy} onClick={() => start(async () => void (await revokeToken(token.id)))}>
            Revoke {token.name}
          </Button>
        )}
        {error !== null && <ProblemBox error={error} />}
      </Table.Td>
    </Table.Tr>
  );
}
