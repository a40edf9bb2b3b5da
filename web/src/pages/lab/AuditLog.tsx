import { Button, Group, Stack, Table, Text } from "@mantine/core";
import { Link } from "react-router";

import { useAudit, type AuditEntry } from "../../api/lab";
import { Loading } from "../../parts/Loading";
import { ProblemBox } from "../../parts/ProblemBox";
import { NothingFound, SearchBox } from "../../parts/SearchBox";
import { useSought } from "../../parts/useSought";
import { When } from "../../parts/When";
import { WideTable } from "../../parts/WideTable";

const PAGES: Record<string, string> = { study: "studies", robot: "robots", device: "devices", payload: "payloads" };

export function AuditLog() {
  const sought = useSought();
  const { data, error, refetch, hasNextPage, fetchNextPage, isFetchingNextPage } = useAudit(sought.words);
  if (error && !data) return <ProblemBox error={error} retry={() => void refetch()} />;
  if (!data) return <Loading what="the audit" />;
  const entries = data.pages.flatMap((page) => page.items);
  return (
    <Stack gap="sm">
      <Text size="sm" c="dimmed">
        Who did what, newest first. Lines are only ever added: the service can change or delete none. Who runs it can put old ones into a file; a line tells that then.
      </Text>
      <Group>
        <SearchBox what="the audit" placeholder="An action, a sort of thing, an id" sought={sought} />
      </Group>
      {entries.length === 0 ? (
        <NothingFound sentence="Nothing of it." clear={sought.clear} />
      ) : (
        <WideTable label="Audit" columns={["When", "Who", "Did", "To", "In words", "Content before", "Content after"]}>
          {entries.map((entry) => (
            <Entry key={entry.id} entry={entry} />
          ))}
        </WideTable>
      )}
      {hasNextPage && (
        <Button variant="default" onClick={() => void fetchNextPage()} loading={isFetchingNextPage} mx="auto">
          Show older ones
        </Button>
      )}
    </Stack>
  );
}

function Entry({ entry }: { entry: AuditEntry }) {
  const page = PAGES[entry.subject_kind];
  const id = entry.subject_id.slice(0, 8);
  return (
    <Table.Tr>
      <Table.Td>
        <When at={entry.created_at} />
      </Table.Td>
      <Table.Td title={entry.actor}>{entry.who}</Table.Td>
      <Table.Td>{entry.action}</Table.Td>
      <Table.Td title={entry.subject_id}>
        {entry.subject_kind} {page ? <Link to={`/${page}/${entry.subject_id}`}>{id}</Link> : <code>{id}</code>}
      </Table.Td>
      <Table.Td>{entry.said}</Table.Td>
      <Table.Td title={entry.before_hash ?? ""}>
        <code>{entry.before_hash?.slice(0, 8)}</code>
      </Table.Td>
      <Table.Td title={entry.after_hash ?? ""}>
        <code>{entry.after_hash?.slice(0, 8)}</code>
      </Table.Td>
    </Table.Tr>
  );
}
