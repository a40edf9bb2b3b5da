import { Alert, Button, Checkbox, Group, Stack, Table, Text, TextInput } from "@mantine/core";
import { useState } from "react";

import { useDeliveries, useWebhookDeeds, useWebhooks, type Event, type Webhook } from "../../api/webhooks";
import { Loading } from "../../parts/Loading";
import { ProblemBox } from "../../parts/ProblemBox";
import { Row, Rows } from "../../parts/Rows";
import { ShownOnce } from "../../parts/ShownOnce";
import { useDeed } from "../../parts/useDeed";
import { When } from "../../parts/When";
import { WideTable } from "../../parts/WideTable";

const EVENTS: [Event, string][] = [
  ["job.ended", "a job has ended"],
  ["publication.published", "something was published"],
  ["publication.revoked", "something was revoked"],
];

/** Addresses that are told what happens in the lab. */
export function Webhooks() {
  const { data, error, refetch } = useWebhooks();
  const { add } = useWebhookDeeds();
  const { start, busy, error: refused } = useDeed();
  const [url, setUrl] = useState("");
  const [events, setEvents] = useState<string[]>(["job.ended"]);
  const [made, setMade] = useState<{ url: string; secret: string } | null>(null);
  const send = () =>
    start(async () => {
      const { webhook, secret } = await add(url.trim(), events as Event[]);
      setMade({ url: webhook.url, secret });
      setUrl("");
    });
  return (
    <Stack gap="sm">
      <Text size="sm" c="dimmed" style={{ maxWidth: "60rem" }}>
        Told by a signed POST (Standard Webhooks) over https, at a public address. What is not taken comes again for three days; then the address is told nothing more.
      </Text>
      <form onSubmit={(event) => { event.preventDefault(); send(); }}>
        <Stack gap="sm">
          <TextInput label="Address" type="url" placeholder="https://…" required maw="36rem" value={url} onChange={(event) => setUrl(event.currentTarget.value)} />
          <Checkbox.Group label="Told when" value={events} onChange={setEvents}>
            <Group gap="md">
              {EVENTS.map(([event, words]) => (
                <Checkbox key={event} value={event} label={words} />
              ))}
            </Group>
          </Checkbox.Group>
          <Group>
            <Button type="submit" loading={busy} disabled={events.length === 0}>
              Add the webhook
            </Button>
          </Group>
        </Stack>
      </form>
      {refused !== null && <ProblemBox error={refused} />}
      {made && <ShownOnce title={`The secret of ${made.url}`} secret={made.secret} onDone={() => setMade(null)} />}
      {error && !data ? (
        <ProblemBox error={error} retry={() => void refetch()} />
      ) : data ? (
        <Rows>
          {data.items.map((each) => (
            <WebhookRow key={each.id} hook={each} />
          ))}
        </Rows>
      ) : (
        <Loading what="the webhooks" />
      )}
    </Stack>
  );
}

function WebhookRow({ hook }: { hook: Webhook }) {
  const { remove, enable, ping } = useWebhookDeeds();
  const { start, busy, error } = useDeed();
  const [shown, setShown] = useState(false);
  const words = (
    <>
      <Text fw={600} style={{ overflowWrap: "anywhere" }}>
        {hook.url}
      </Text>
      <Text size="sm" c="dimmed">
        {hook.events.map((event) => EVENTS.find(([name]) => name === event)?.[1] ?? event).join(", ")}
      </Text>
      {hook.disabled_at && (
        <Alert color="red" title="Told nothing more">
          Since <When at={hook.disabled_at} />: {hook.disabled_because}
        </Alert>
      )}
      {error !== null && <ProblemBox error={error} />}
      {shown && <Deliveries id={hook.id} />}
    </>
  );
  return (
    <Row words={words}>
      <Group gap="xs">
        {hook.disabled_at ? (
          <Button size="xs" variant="default" loading={busy} onClick={() => start(() => enable(hook.id) as Promise<void>)}>
            Tell it again
          </Button>
        ) : (
          <Button size="xs" variant="default" loading={busy} onClick={() => start(async () => { await ping(hook.id); setShown(true); })}>
            Try it
          </Button>
        )}
        <Button size="xs" variant="default" aria-expanded={shown} onClick={() => setShown(!shown)}>
          What it was told
        </Button>
        <Button size="xs" variant="default" loading={busy} onClick={() => start(() => remove(hook.id) as Promise<void>)}>
          Remove the webhook
        </Button>
      </Group>
    </Row>
  );
}

function Deliveries({ id }: { id: string }) {
  const { data, error } = useDeliveries(id);
  if (error) return <ProblemBox error={error} />;
  if (!data) return <Loading what="what it was told" lines={1} />;
  if (data.items.length === 0) return <Text size="sm">Nothing yet.</Text>;
  return (
    <WideTable label="What it was told" tight columns={["When", "What", "State", "Tries", "Last answer"]}>
      {data.items.map((each) => (
        <Table.Tr key={each.id}>
          <Table.Td><When at={each.created_at} /></Table.Td>
          <Table.Td>{each.event}</Table.Td>
          <Table.Td>{each.state}</Table.Td>
          <Table.Td>{each.attempts}</Table.Td>
          <Table.Td>{each.said || each.status}</Table.Td>
        </Table.Tr>
      ))}
    </WideTable>
  );
}
