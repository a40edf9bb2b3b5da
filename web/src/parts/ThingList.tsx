import { Anchor, Button, Group, Text, Title } from "@mantine/core";
import { useEffect, type ReactNode } from "react";
import { Link } from "react-router";

import type { LatestJob } from "../api/studies";
import { Loading } from "./Loading";
import { ProblemBox } from "./ProblemBox";
import { AtRight, Row, Rows } from "./Rows";
import styles from "./Rows.module.css";
import { NothingFound, SearchBox } from "./SearchBox";
import { StateBadge } from "./StateBadge";
import type { Sought } from "./useSought";
import { When } from "./When";

/** What a query gives that brings page after page. */
export type Pages<Thing> = {
  data: Thing[] | undefined;
  error: Error | null;
  refetch: () => unknown;
  hasNextPage: boolean;
  fetchNextPage: () => unknown;
  isFetchingNextPage: boolean;
};

/** nothing, found: told of what was sought; beside: what else it is chosen by, and whether it is (seeking). */
type Search = { sought: Sought; placeholder: string; nothing: string; found?: string; seeking?: boolean; beside?: ReactNode };

/** Things of one sort, newest first, with a box to search them. none: in place of all, where there are none at all. */
export function ThingList<Thing extends { id: string }>({ things, title = "Handed in", pages, search, none, row }: {
  things: string;
  title?: string;
  pages: Pages<Thing>;
  search?: Search;
  none: ReactNode;
  row: (thing: Thing) => ReactNode;
}) {
  const { data, error, refetch, hasNextPage, fetchNextPage, isFetchingNextPage } = pages;
  if (error && !data) return <ProblemBox error={error} retry={() => void refetch()} />;
  if (!data) return <Loading what={`the ${things}`} />;
  const seeking = search && (search.seeking ?? search.sought.words !== "");
  if (data.length === 0 && !seeking) return none;
  return (
    <section aria-labelledby={things}>
      <Group justify="space-between" align="flex-end" mb="sm">
        <Title order={2} size="h3" id={things}>
          {title}
        </Title>
        {search && (
          <Group gap="sm" wrap="nowrap" flex="1 1 12rem" maw="34rem" justify="flex-end">
            <SearchBox what={things} placeholder={search.placeholder} sought={search.sought} />
            {search.beside}
          </Group>
        )}
      </Group>
      {search && data.length === 0 && <NothingFound sentence={search.nothing} clear={search.sought.clear} />}
      {seeking && search.found && data.length > 0 && (
        <Text size="sm" c="dimmed" role="status" mb="sm">
          {search.found}
        </Text>
      )}
      <Rows>{data.map(row)}</Rows>
      {hasNextPage && (
        <Group justify="center" mt="sm">
          <Button variant="default" onClick={() => void fetchNextPage()} loading={isFetchingNextPage}>
            Show older {things}
          </Button>
        </Group>
      )}
    </section>
  );
}

/** What it is called and is, in a row; why its newest job failed, if it did. */
export function ThingRow({ to, name, facts, job, children }: {
  to: string;
  name: string;
  facts: string;
  job?: LatestJob | null;
  children: ReactNode;
}) {
  const words = (
    <>
      <Anchor component={Link} to={to} fw={600}>
        {name}
      </Anchor>
      <Text size="sm" c="dimmed">
        {facts}
      </Text>
      {job?.state === "failed" && job.reason && (
        <Text size="sm" lineClamp={2} className={styles.reason}>
          {job.reason}
        </Text>
      )}
    </>
  );
  return <Row words={words}>{children}</Row>;
}

/** The end of a row: the state of its job, its version, its age. job: undefined where it has none by nature. */
export function Standing({ at, version, of = 1, job }: { at: string; version?: number; of?: number; job?: LatestJob | null }) {
  return (
    <>
      {job !== undefined && <StateBadge state={job?.state} />}
      <AtRight>
        {version !== undefined && (
          <>
            {of > 1 ? `version ${version} of ${of}` : `version ${version}`}
            <br />
          </>
        )}
        <When at={at} />
      </AtRight>
    </>
  );
}

/** All pages, one after the other: versions of one thing stand in one row. The newest of each name, and how many there are. */
export function useNewestOfEach<Thing extends { name: string }>(pages: Pages<Thing>): Pages<Thing & { versions: number }> {
  const { data, error, hasNextPage, isFetchingNextPage, fetchNextPage } = pages;
  useEffect(() => {
    if (hasNextPage && !error && !isFetchingNextPage) void fetchNextPage();
  }, [hasNextPage, error, isFetchingNextPage, fetchNextPage]);
  const newest = new Map<string, Thing & { versions: number }>();
  for (const thing of data ?? []) {
    const known = newest.get(thing.name);
    if (known) known.versions += 1;
    else newest.set(thing.name, { ...thing, versions: 1 });
  }
  return { ...pages, hasNextPage: false, data: data && [...newest.values()] };
}
