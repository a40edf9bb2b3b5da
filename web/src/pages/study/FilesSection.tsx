import { Anchor, Stack, Table, Text, TextInput, Title } from "@mantine/core";
import { useState } from "react";

import { address } from "../../app/base";
import { Loading } from "../../parts/Loading";
import { ProblemBox } from "../../parts/ProblemBox";
import { count, sizeOf } from "../../parts/size";
import { number, WideTable } from "../../parts/WideTable";
import type { Job } from "./jobs";
import { useArtifacts } from "./results";

const ABOUT: Record<string, string> = {
  "report.html": "everything to read and to print, in one file",
  "summary.html": "one page: scope, findings, configuration",
  "summary.pdf": "the same page, to print and to send",
  "results.json": "every number, to compute with",
  "parameters.csv": "parameters of the robot, with standard deviations",
  "validation.csv": "errors per channel and log",
  "support.csv": "supporting torque per device, motion, joint and phase",
  "stiffness.csv": "stiffness and natural length of the bands",
  "results.schema.json": "the shape of results.json",
  "motion.csv": "the motion: t and q.<joint>, as it was planned",
  "plan.json": "trunk, margins, broken bounds, parameters: what this page shows",
  "motion.json": "ranges, top speeds, margins and hashes of the motion",
  "human.npz": "the person, as the 3D view draws it",
  "played.npz": "the robot’s postures, as the 3D view plays them",
  "identified.urdf": "the maker’s URDF with identified inertias",
};

/** What a reader looks for first; the many series last. */
function byUse(one: { name: string }, other: { name: string }): number {
  const rank = ({ name }: { name: string }) => {
    const place = Object.keys(ABOUT).indexOf(name);
    return place >= 0 ? place : name.startsWith("series/") ? 200 : 100;
  };
  return rank(one) - rank(other) || one.name.localeCompare(other.name);
}

function aboutOf(name: string): string {
  if (name === "series/motion.parquet") return "trunk, margins, bounds and joints over time";
  if (name.startsWith("series/")) return "the log’s channels, with what the models say";
  if (name.startsWith("planned_motion_")) return "joint positions of a motion that would tell effects apart";
  return ABOUT[name] ?? "";
}

/** What the job made, to take away. */
export function FilesSection({ job }: { job: Job }) {
  const { data, error, refetch } = useArtifacts(job.id, job.state === "succeeded");
  const [wanted, setWanted] = useState("");
  if (error) return <ProblemBox error={error} retry={() => void refetch()} />;
  if (!data) return <Loading what="the files" />;
  const files = data.items.filter((file) => file.name.toLowerCase().includes(wanted.trim().toLowerCase())).sort(byUse);
  return (
    <Stack gap="md">
      <Title order={2} size="h3">
        Files
      </Title>
      <TextInput
        label="Find a file"
        placeholder="part of its name"
        maw={340}
        value={wanted}
        onChange={(event) => setWanted(event.currentTarget.value)}
      />
      <Text size="sm" c="dimmed" role="status">
        {count(files.length, "file")}
        {files.length < data.items.length && ` of ${data.items.length}`}, {sizeOf(files.reduce((sum, file) => sum + file.size, 0))}
      </Text>
      <WideTable label="Files that the job made" columns={["File", "What it holds", number("Size"), "SHA-256"]}>
        {files.map((file) => (
          <Table.Tr key={file.name}>
            <Table.Th scope="row">
              <Anchor size="sm" href={address(`api/v1/${file.href}`)} {...(file.name.endsWith(".html") ? { target: "_blank" } : { download: true })}>
                {file.name}
              </Anchor>
            </Table.Th>
            <Table.Td>{aboutOf(file.name)}</Table.Td>
            <Table.Td data-number>{sizeOf(file.size)}</Table.Td>
            <Table.Td>
              <Text size="xs" ff="monospace" title={file.sha256}>
                {file.sha256.slice(0, 12)}…
              </Text>
            </Table.Td>
          </Table.Tr>
        ))}
      </WideTable>
    </Stack>
  );
}
