import { Anchor, Box, Code, Group, List, Paper, Stack, Table, Text, Title } from "@mantine/core";

import { address } from "../../app/base";
import { FactList } from "../../parts/FactList";
import { figure, NONE } from "../../parts/digits";
import { count } from "../../parts/size";
import { When } from "../../parts/When";
import { numbers, WideTable } from "../../parts/WideTable";
import { FollowedSection } from "./FollowedPlans";
import type { Job } from "./jobs";
import type { Results } from "./results";
import { range, route, speed, type Configuration, type Scope, type StatedBand, type Told } from "./scope";
import { ROLES } from "./summary";

const WORDS: Record<string, string> = {
  recorded: "date of recording",
  robot_cover: "robot cover",
  serial: "serial number",
  straps: "strap settings",
  pretension: "pre-tension",
  garment: "garment below",
};
const PAGES = { "summary.html": "One-page report", "summary.pdf": "The same as PDF" };

/** For what the results hold, with what they were obtained, and one page of it to take away. */
export function ScopeSection({ job, results }: { job: Job; results: Results }) {
  const { scope, configuration } = results;
  if (!scope || !configuration)
    return (
      <>
        <Title order={2} size="h3" mb="xs">
          Scope
        </Title>
        <Text>An earlier version made this job and did not write down its scope. Evaluate the study again to get it.</Text>
      </>
    );
  return (
    <Stack gap="xl">
      <section aria-labelledby="scope">
        <Title order={2} size="h3" id="scope" mb="xs">
          Scope
        </Title>
        <Paper withBorder p="md" data-scope>
          <Text>{scope.sentence}</Text>
        </Paper>
        <Group gap="lg" mt="sm">
          {Object.entries(PAGES).map(([name, words]) => (
            <Anchor key={name} href={address(`api/v1/jobs/${job.id}/artifacts/${name}`)} {...(name.endsWith(".html") ? { target: "_blank" } : { download: true })}>
              {words}
            </Anchor>
          ))}
          {job.finished_at && (
            <Text size="sm" c="dimmed">
              Evaluated <When at={job.finished_at} />
            </Text>
          )}
        </Group>
      </section>
      <section aria-labelledby="unsaid">
        <Title order={2} size="h3" id="unsaid" mb="xs">
          What these data cannot say
        </Title>
        <List style={{ maxWidth: "60rem" }}>
          {scope.not_said.map((each) => (
            <List.Item key={each}>{each}</List.Item>
          ))}
        </List>
      </section>
      <FollowedSection plans={results.plans} />
      <Reached scope={scope} />
      <Configured results={results} found={configuration} />
    </Stack>
  );
}

/** With the wear, beside what the fitted logs reach; without a wear, the fitted logs alone. */
function Reached({ scope }: { scope: Scope }) {
  const fitted = new Map(scope.identified.map((each) => [each.joint, each]));
  const worn = scope.motions.flatMap(({ motion, device, joints }) =>
    [...joints].sort((one, other) => Number(other.main) - Number(one.main)).map((reach) => ({ motion, device, reach })),
  );
  const rows = worn.length ? worn : scope.identified.map((reach) => ({ motion: NONE, device: NONE, reach }));
  if (!rows.length) return null;
  return (
    <section aria-labelledby="reached">
      <Title order={2} size="h3" id="reached" mb="xs">
        How far and how fast
      </Title>
      <WideTable
        label="Positions and speeds that were reached"
        mostHeight="26rem"
        columns={[
          "Joint",
          ...(worn.length ? ["Motion", "Wear", ...numbers("Positions", "Top speed")] : []),
          ...numbers("In the fitted logs", "Top speed there"),
        ]}
      >
        {rows.map(({ motion, device, reach }) => {
          const fit = fitted.get(reach.joint);
          return (
            <Table.Tr key={`${device}|${motion}|${reach.joint}`} data-reach={`${device}|${motion}|${reach.joint}`}>
              <Table.Th scope="row">{reach.joint}</Table.Th>
              {worn.length > 0 && <Table.Td>{motion}</Table.Td>}
              {worn.length > 0 && <Table.Td miw="9rem">{device}</Table.Td>}
              {worn.length > 0 && <Table.Td data-number>{range(reach)}</Table.Td>}
              {worn.length > 0 && <Table.Td data-number>{reach.moved ? speed(reach) : "not moved"}</Table.Td>}
              <Table.Td data-number>{fit ? range(fit) : NONE}</Table.Td>
              <Table.Td data-number>{!fit ? NONE : fit.moved ? speed(fit) : "not moved"}</Table.Td>
            </Table.Tr>
          );
        })}
      </WideTable>
    </section>
  );
}

function Configured({ results, found }: { results: Results; found: Configuration }) {
  const { robot } = found;
  return (
    <section aria-labelledby="configuration">
      <Title order={2} size="h3" id="configuration" mb="xs">
        Configuration
      </Title>
      <FactList
        facts={[
          ["Data", found.synthetic.length ? `synthetic, as ${some(found.synthetic)} say` : results.scope?.synthetic ? "synthetic" : "measured, as far as the files say"],
          ["Robot", `${robot.name}, ${robot.base} base, ${count(robot.joints.length, "joint")}, ${count(robot.moving_links, "moving link")}, ${count(robot.sensors.length, "force/torque sensor")}`],
          ["Conditions", told(found.conditions)],
          ["Logs", logWords(found)],
          ["Settings used", settingWords(found.settings)],
          ["Software", Object.entries(results.software).map((each) => each.join(" ")).join(", ")],
          ["Input files", <>{count(results.inputs.length, "file")}; SHA-256 of the list of their hashes <Code>{found.inputs_sha256}</Code></>],
        ]}
      />
      {found.devices.map((each) => (
        <section key={each.device} aria-labelledby={`wear-${each.file}`}>
          <Title order={3} size="h4" id={`wear-${each.file}`} mt="lg" mb="xs">
            {each.device}
          </Title>
          <FactList
            facts={[
              ["File", each.file],
              ["Worn in", each.logs.length ? each.logs.join(", ") : "no log"],
              ["Specimen", <Specimen key="specimen" record={each.record} />],
            ]}
          />
          <Box mt="xs">
            <Bands device={each.device} bands={each.bands} />
          </Box>
        </section>
      ))}
    </section>
  );
}

function Specimen({ record }: { record: Told }) {
  if (Object.values(record).some((value) => value !== null)) return told(record);
  return (
    <>
      {told(record)} To have it in the next evaluation, say it under <Code>record</Code> in the device’s file.
    </>
  );
}

function Bands({ device, bands }: { device: string; bands: StatedBand[] }) {
  return (
    <WideTable
      label={`Bands of ${device} as stated`}
      columns={["Band", "Group", "Runs over", "Law", ...numbers("Stiffness as stated", "Natural length as stated")]}
    >
      {bands.map((band) => (
        <Table.Tr key={band.band}>
          <Table.Th scope="row">{band.band}</Table.Th>
          <Table.Td>{band.group}</Table.Td>
          <Table.Td miw="12rem">
            {route(band)}, {count(band.via_points.length, "via point")}
          </Table.Td>
          <Table.Td>{band.law}</Table.Td>
          <Table.Td data-number>{stated(band.stiffness_n_per_m, "N/m", band.ground_truth)}</Table.Td>
          <Table.Td data-number>{stated(band.natural_length_m, "m", band.ground_truth)}</Table.Td>
        </Table.Tr>
      ))}
    </WideTable>
  );
}

function stated(value: number | null, unit: string, truth: boolean): string {
  return value === null ? "not stated" : `${figure(value)} ${unit}${truth ? ", true" : ""}`;
}

/** What was said, then what was not: a gap in a record should be seen. */
function told(entry: Told): string {
  const said = Object.entries(entry).filter(([, value]) => value !== null);
  const silent = Object.keys(entry).filter((key) => entry[key] === null);
  const words = said.map(([key, value]) => `${WORDS[key] ?? key} ${value}`).join(", ");
  const gaps = silent.length ? `Not stated: ${silent.map((key) => WORDS[key] ?? key).join(", ")}.` : "";
  return [words && `${words}.`, gaps].filter(Boolean).join(" ");
}

function logWords({ logs }: Configuration): string {
  const roles = [...new Set(logs.map((log) => log.role))];
  return roles.map((role) => `${logs.filter((log) => log.role === role).length} ${(ROLES[role] ?? role).toLowerCase()}`).join(", ") || NONE;
}

function settingWords(settings: Record<string, unknown>): string {
  const shown = (value: unknown): string =>
    Array.isArray(value)
      ? value.join(", ")
      : typeof value === "number"
        ? figure(value)
        : value && typeof value === "object"
          ? Object.entries(value).map(([name, each]) => `${name} ${shown(each)}`).join(", ") || "none"
          : String(value);
  return Object.entries(settings)
    .map(([key, value]) => `${key}: ${shown(value)}`)
    .join("; ");
}

function some(files: string[]): string {
  return files.length > 3 ? `${files.slice(0, 3).join(", ")} and ${files.length - 3} more` : files.join(", ");
}
