import { Button, Code, Group, NativeSelect, Stack, Text } from "@mantine/core";
import { IconDownload } from "@tabler/icons-react";
import { useNavigate } from "react-router";

import { useSubmitJob } from "../../../api/studies";
import { NumberField } from "../../../parts/NumberField";
import { ProblemBox } from "../../../parts/ProblemBox";
import { useDeed } from "../../../parts/useDeed";
import { PayloadFindings } from "../PayloadFindings";
import { AddFiles } from "./AddFiles";
import { saysOf, type Fault } from "./faults";
import { Beside } from "./Fields";
import { LogTable } from "./LogTable";
import { takeAs } from "./RecordStep";
import { Part } from "./SensorStep";
import type { Drafted } from "./useDraft";

type Props = { drafted: Drafted; faults: readonly Fault[]; tried: boolean; ready: boolean; kept: (id: string) => void };

/** What is left to say, what the doctor finds, the file itself, and the identification. */
export function ResultStep({ drafted, faults, tried, ready, kept }: Props) {
  const { draft, set, verdict, text, judging } = drafted;
  const { content } = draft;
  const says = saysOf(faults, tried);
  const submit = useSubmitJob();
  const navigate = useNavigate();
  const { start, busy, error } = useDeed();
  const identifies = content.logs.some(({ role }) => role === "postures" || role === "excitation");
  const run = async () => {
    const id = await drafted.keep();
    kept(id);
    if (identifies) await submit.mutateAsync({ payload_id: id, kind: "payload", settings: {} });
    await navigate(`/payloads/${id}`);
  };
  return (
    <Stack gap="xl">
      <Part title="Logs that judge, if you have any">
        <AddFiles title="Drop logs in which nothing touches the payload" several take={takeAs(drafted, "test")}>
          They tell what is left when everything is taken out. Logs in which something touches it get the role Contact.
        </AddFiles>
        <LogTable label="Logs that judge" drafted={drafted} roles={["test", "contact"]} faults={faults} />
      </Part>
      <Part title="Logs that identify">
        {content.logs.length === 0 ? <Text size="sm">None yet: this payload can only be planned for.</Text> : <LogTable label="Logs that identify" drafted={drafted} roles={["postures", "excitation"]} faults={faults} />}
      </Part>
      <Part title="If you know more">
        <Beside>
          <NumberField
            label="Weighed mass [kg]"
            description="For comparison; it is never fitted."
            value={content.ground_truth?.mass_kg}
            error={says("ground_truth.mass_kg")}
            set={(mass_kg) => set((now) => ({ ...now, ground_truth: mass_kg === undefined ? undefined : { mass_kg } }))}
          />
          <NativeSelect
            label="Inclination of the base"
            description="Found where it predicts left-out postures better."
            value={(content.settings?.["inclination"] as string | undefined) ?? "auto"}
            data={[
              { value: "auto", label: "let the postures decide" },
              { value: "fit", label: "always find it" },
              { value: "ignore", label: "the base is level" },
            ]}
            onChange={(event) => {
              const inclination = event.currentTarget.value;
              set((now) => ({ ...now, settings: { ...now.settings, inclination: inclination === "auto" ? undefined : inclination } }));
            }}
          />
        </Beside>
      </Part>
      {verdict?.findings && <PayloadFindings findings={verdict.findings} />}
      {judging && content.logs.length > 0 && <Text size="sm" role="status">The logs are examined …</Text>}
      <Part title="payload.yaml">
        <Code block tabIndex={0} role="region" aria-label="Text of payload.yaml" mah="20rem" style={{ overflow: "auto" }} data-testid="yaml">
          {text}
        </Code>
        <div>
          <Button component="a" variant="default" href={`data:application/yaml;charset=utf-8,${encodeURIComponent(text)}`} download="payload.yaml" leftSection={<IconDownload size={16} aria-hidden />}>
            Download payload.yaml
          </Button>
        </div>
      </Part>
      <Group gap="sm">
        <Button disabled={!ready} loading={busy} onClick={() => start(run)}>
          {identifies ? "Identify" : "Keep it"}
        </Button>
        {!ready && (
          <Text size="sm" c="dimmed">
            {judging ? "It is tried …" : "First say what is missing."}
          </Text>
        )}
      </Group>
      {error !== null && <ProblemBox error={error} />}
    </Stack>
  );
}
