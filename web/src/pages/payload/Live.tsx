import { Anchor, Stack, Table, Text, Title } from "@mantine/core";

import { useStreams, type LiveStream } from "../../api/live";
import type { Payload } from "../../api/payloads";
import { address } from "../../app/base";
import { NONE } from "../../parts/digits";
import { Loading } from "../../parts/Loading";
import { ProblemBox } from "../../parts/ProblemBox";
import { sizeOf } from "../../parts/size";
import { When } from "../../parts/When";
import { number, WideTable } from "../../parts/WideTable";
import { LiveView } from "./LiveView";

const WORDS: Record<string, string> = { open: "running", ended: "ended", lost: "lost" };

/** Streams of the sensor: those that run, to be watched, and the logs of those that ended. */
export function Live({ payload }: { payload: Payload }) {
  const { data: streams, error, refetch } = useStreams(payload.id);
  const running = streams?.filter(({ state }) => state === "open") ?? [];
  return (
    <section aria-labelledby="live">
      <Title order={2} size="h3" id="live" mb="xs">
        Live
      </Title>
      <Stack gap="md">
        {error && !streams ? <ProblemBox error={error} retry={() => void refetch()} /> : !streams ? <Loading what="the streams" lines={1} /> : null}
        {streams?.length === 0 && <Text size="sm">No stream yet. A robot’s program sends one with Client.live; it is then shown here.</Text>}
        {running.map((stream) => (
          <LiveView key={stream.id} stream={stream} />
        ))}
        {streams && streams.length > 0 && <Streams streams={streams} />}
      </Stack>
    </section>
  );
}

function Streams({ streams }: { streams: LiveStream[] }) {
  return (
    <WideTable label="Streams" mostHeight="20rem" columns={["Began", "State", "Ended", number("Samples"), number("Dropped"), number("Late"), "Log"]}>
      {streams.map((stream) => (
        <Table.Tr key={stream.id} data-stream={stream.id}>
          <Table.Th scope="row">
            <When at={stream.started_at} />
          </Table.Th>
          <Table.Td>{WORDS[stream.state] ?? stream.state}</Table.Td>
          <Table.Td>{stream.ended_at ? <When at={stream.ended_at} /> : NONE}</Table.Td>
          <Table.Td data-number>{stream.samples}</Table.Td>
          <Table.Td data-number>{stream.dropped}</Table.Td>
          <Table.Td data-number>{stream.late}</Table.Td>
          <Table.Td>
            {stream.size === null ? (
              NONE
            ) : (
              <Anchor size="sm" href={address(`api/v1/streams/${stream.id}/log`)} download aria-label={`Log of the stream ${stream.id}`}>
                Parquet, {sizeOf(stream.size)}
              </Anchor>
            )}
          </Table.Td>
        </Table.Tr>
      ))}
    </WideTable>
  );
}
