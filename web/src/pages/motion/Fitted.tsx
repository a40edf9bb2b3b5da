import { Anchor, Group, Stack } from "@mantine/core";

import { useTextFile } from "../../api/files";
import { address } from "../../app/base";
import { FactList } from "../../parts/FactList";
import { useArtifacts } from "../study/results";
import { toldWords } from "./facts";

const ELSEWHERE = ["name", "frames", "seconds"]; // shown of the capture

/** The body that was fitted: how well it fits, what is told of it, and its angles to take away. */
export function Fitted({ jobId }: { jobId: string }) {
  const { data: made } = useArtifacts(jobId, true);
  const hrefs = Object.fromEntries((made?.items ?? []).map(({ name, href }) => [name, address(`api/v1/${href}`)]));
  const { data: text } = useTextFile(hrefs["fit.json"]);
  if (!text) return null;
  const { told } = JSON.parse(text) as { told: Record<string, string | number> };
  const facts = Object.entries(told)
    .filter(([key]) => !ELSEWHERE.includes(key))
    .map(([key, words]): [string, string] => [toldWords(key), String(words)]);
  return (
    <Stack gap="xs">
      <FactList facts={facts} />
      <Group gap="md">
        <Anchor href={hrefs["angles.mot"]} download size="sm" underline="always">
          Angles over time: MOT
        </Anchor>
        <Anchor href={hrefs["fit.json"]} download size="sm" underline="always">
          Lengths and places of markers: JSON
        </Anchor>
      </Group>
    </Stack>
  );
}
