import { Alert, Anchor, Button, Code, CopyButton, Group, Stack, Text, Title } from "@mantine/core";
import { Link, useParams } from "react-router";

import { publishedAddress, publishedFile, usePublished, usePublishedResults, type Published } from "../../api/publications";
import { FactList } from "../../parts/FactList";
import { FileTable } from "../../parts/FileTable";
import { Loading } from "../../parts/Loading";
import { PageTitle } from "../../parts/PageTitle";
import { ProblemBox } from "../../parts/ProblemBox";
import { When } from "../../parts/When";
import { SummarySection } from "../study/SummarySection";
import { isEvaluation } from "../study/results";

/** A snapshot, for everybody: what it is, what was found, every file with its hash. Revoked: what it was. */
export function Component() {
  const { key = "" } = useParams();
  const { data, error, refetch } = usePublished(key);
  if (error && !data) return <ProblemBox error={error} retry={() => void refetch()} />;
  if (!data) return <Loading what="the publication" />;
  const gone = data.revoked_at !== null;
  return (
    <>
      <PageTitle title={data.title} lead={`Published by ${data.lab}, version ${data.version}`} />
      <Stack gap="xl">
        {gone && (
          <Alert color="red" title="Revoked" role="alert">
            Since <When at={data.revoked_at!} /> its files are not published any more: {data.revoked_because}
          </Alert>
        )}
        <Newer found={data} />
        <About found={data} />
        {!gone && <Found found={data} />}
        <Files found={data} gone={gone} />
      </Stack>
    </>
  );
}

function Newer({ found }: { found: Published }) {
  const newest = found.versions.filter((each) => each.revoked_at === null).at(-1);
  if (!newest || newest.version <= found.version) return null;
  return (
    <Alert title="There is a newer version">
      <Anchor component={Link} to={`/published/${newest.key}`} underline="always">
        Version {newest.version}
      </Anchor>
    </Alert>
  );
}

function About({ found }: { found: Published }) {
  const creators = found.creators.map((each) => (
    <div key={each.name}>
      {each.name}
      {each.affiliation && `, ${each.affiliation}`}
      {each.orcid && <Text span size="sm" c="dimmed"> ORCID {each.orcid}</Text>}
    </div>
  ));
  return (
    <section aria-labelledby="about">
      <Title order={2} size="h3" id="about" mb="sm">
        About
      </Title>
      {found.description && <Text mb="sm" style={{ whiteSpace: "pre-line", maxWidth: "60rem" }}>{found.description}</Text>}
      <FactList
        facts={[
          ["Creators", creators],
          ["Published", <When key="at" at={found.created_at} />],
          ["Licence", found.licence ?? ""],
          ["Permalink", <Anchor key="url" href={found.url}>{found.url}</Anchor>],
          ...(found.doi ? [["DOI", found.doi] as [string, string]] : []),
          ["Versions", <Versions key="versions" found={found} />],
        ]}
      />
      <Group gap="sm" mt="sm" align="flex-start">
        <Text size="sm" style={{ maxWidth: "50rem" }} data-testid="citation">
          {found.citation}
        </Text>
        <CopyButton value={found.citation}>
          {({ copied, copy }) => (
            <Button size="xs" variant="default" onClick={copy}>
              {copied ? "Copied" : "Copy the citation"}
            </Button>
          )}
        </CopyButton>
        <Anchor size="sm" href={publishedAddress(found.key, "datacite")} download={`${found.key}.datacite.json`}>
          DataCite metadata
        </Anchor>
      </Group>
    </section>
  );
}

function Versions({ found }: { found: Published }) {
  return found.versions.map((each) => (
    <div key={each.key}>
      {each.key === found.key ? (
        `version ${each.version}, this one`
      ) : (
        <Anchor component={Link} to={`/published/${each.key}`} underline="always">
          version {each.version}
        </Anchor>
      )}
      {each.revoked_at && ", revoked"}
    </div>
  ));
}

function Found({ found }: { found: Published }) {
  const { data: results, error, refetch } = usePublishedResults(found);
  const report = found.files.find((each) => each.path === "results/report.html");
  if (error) return <ProblemBox error={error} retry={() => void refetch()} />;
  if (!results) return <Loading what="the results" />;
  return (
    <section aria-labelledby="found">
      <Group justify="space-between" mb="sm">
        <Title order={2} size="h3" id="found">
          What was found
        </Title>
        {report && (
          <Anchor href={publishedFile(found.key, report.path)} target="_blank" rel="noopener">
            The whole report
          </Anchor>
        )}
      </Group>
      {isEvaluation(results) ? <SummarySection results={results} /> : <Text>An earlier version of exogauge wrote the results; the report tells them.</Text>}
    </section>
  );
}

function Files({ found, gone }: { found: Published; gone: boolean }) {
  return (
    <section aria-labelledby="files">
      <Title order={2} size="h3" id="files" mb="sm">
        Files and their hashes
      </Title>
      <Text size="sm" c="dimmed" mb="sm">
        SHA-256 over all paths and hashes: <Code style={{ overflowWrap: "anywhere" }}>{found.content_hash}</Code>.{" "}
        {gone ? "What you kept can be checked by " : "Check what you fetched by "}
        <Anchor inherit href={publishedAddress(found.key, "SHA256SUMS")} download="SHA256SUMS" underline="always">
          SHA256SUMS
        </Anchor>{" "}
        and <Code>sha256sum -c</Code>.
      </Text>
      <FileTable label="Files" files={found.files} href={gone ? undefined : (path) => publishedFile(found.key, path)} />
    </section>
  );
}
