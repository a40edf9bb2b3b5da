import { Button, Checkbox, Group, NativeSelect, Paper, Stack, Table, Text, TextInput, Title } from "@mantine/core";
import { useEffect } from "react";
import { useNavigate } from "react-router";

import type { Schemas } from "../../api/client";
import { useDevices } from "../../api/devices";
import { useCreateStudy, useLogs, type LogSummary } from "../../api/imports";
import { useSubmitJob } from "../../api/studies";
import { useKept } from "../../app/kept";
import { ProblemBox } from "../../parts/ProblemBox";
import { count } from "../../parts/size";
import { useDeed } from "../../parts/useDeed";
import { When } from "../../parts/When";
import { WideTable } from "../../parts/WideTable";
import { fixed } from "../../parts/digits";

type Role = Schemas["LogPart"]["role"];
/** began: time of the day, hh:mm:ss; empty where it is not known. */
type Use = { role: Role | ""; motion: string; began: string };

const UNUSED: Use = { role: "", motion: "", began: "" };

const ROLES = [
  { value: "", label: "Not in this study" },
  { value: "identification", label: "To identify the robot" },
  { value: "validation", label: "Held out, to validate" },
  { value: "without_device", label: "Motion without the device" },
  { value: "with_device", label: "Motion with the device" },
];
const MOVES = ["without_device", "with_device"];

/** Stored logs, each with its role, put together with a robot and a device. */
export function StudyForm({ robotId, fresh }: { robotId: string | undefined; fresh: string[] }) {
  const { data: logs } = useLogs();
  const { data: devices = [] } = useDevices({ robot_id: robotId });
  const [uses, setUses] = useKept<Record<string, Use>>("uses", {});
  const [name, setName] = useKept("name", "");
  const [device, setDevice] = useKept("device", "");
  const [evaluate, setEvaluate] = useKept("evaluate", true);
  const create = useCreateStudy();
  const submit = useSubmitJob();
  const navigate = useNavigate();
  const { start, busy, error } = useDeed();
  useEffect(() => {
    setUses((before) => ({ ...Object.fromEntries(fresh.map((id) => [id, { ...UNUSED, role: "identification" as const }])), ...before }));
  }, [fresh.join()]);
  if (!logs || logs.items.length === 0 || !robotId) return null;
  const used = logs.items.flatMap((log) => {
    const use = { ...UNUSED, ...uses[log.id] };
    return use.role ? [{ log, role: use.role, motion: use.motion.trim(), started: secondsOf(use.began) }] : [];
  });
  const missing = hindrance(name, used, device);
  const build = async () => {
    const nothing = { device_id: null, name: null, rows: null };
    const parts = used.map(({ log, role, motion, started }) => ({ ...nothing, log_id: log.id, role, started, motion: MOVES.includes(role) ? motion : null }));
    const study = await create.mutateAsync({ name: name.trim(), robot_id: robotId, device_id: device || null, logs: parts, settings: null, steps: null, known: null });
    if (evaluate && !study.latest_job) await submit.mutateAsync({ study_id: study.id, kind: "evaluate", settings: {} });
    await navigate(`/studies/${study.id}`);
  };
  const say = (id: string, use: Partial<Use>) => setUses({ ...uses, [id]: { ...UNUSED, ...uses[id], ...use } });
  return (
    <section aria-labelledby="study-form">
      <Title order={2} size="h3" id="study-form" mb="sm">
        Put stored logs into a study
      </Title>
      <Stack gap="sm">
        <WideTable label="Stored logs" mostHeight="24rem" columns={["Log", "Holds", "Stored", "Role", "Motion", "Began at"]}>
          {logs.items.map((log) => {
            const { channels = [], duration_s, rate_hz } = log.summary as LogSummary;
            const use = { ...UNUSED, ...uses[log.id] };
            return (
              <Table.Tr key={log.id}>
                <Table.Th scope="row">{log.name}</Table.Th>
                <Table.Td>
                  {count(channels.length, "channel")}, {fixed(duration_s, 1)} s at {fixed(rate_hz, 0)} Hz
                </Table.Td>
                <Table.Td>
                  <When at={log.created_at} />
                </Table.Td>
                <Table.Td>
                  <NativeSelect
                    size="xs"
                    aria-label={`Role of ${log.name}`}
                    value={use.role}
                    data={ROLES}
                    onChange={(event) => say(log.id, { role: event.currentTarget.value as Role | "" })}
                  />
                </Table.Td>
                <Table.Td>
                  <TextInput
                    size="xs"
                    aria-label={`Motion of ${log.name}`}
                    placeholder="bend, lift …"
                    disabled={!MOVES.includes(use.role)}
                    value={use.motion}
                    maxLength={200}
                    onChange={(event) => say(log.id, { motion: event.currentTarget.value })}
                  />
                </Table.Td>
                <Table.Td>
                  <TextInput
                    size="xs"
                    type="time"
                    step={1}
                    aria-label={`When ${log.name} began`}
                    disabled={use.role === ""}
                    value={use.began}
                    onChange={(event) => say(log.id, { began: event.currentTarget.value })}
                  />
                </Table.Td>
              </Table.Tr>
            );
          })}
        </WideTable>
        <Text size="sm" c="dimmed">
          When each began, on one day: then what motors gave as they warmed is found and taken off. It asks for the time of every log, and for
          motions without the device before and after those with it.
        </Text>
        <Paper withBorder p="md">
          <Group align="flex-end" gap="lg">
            <TextInput label="Name of the study" value={name} maxLength={200} onChange={(event) => setName(event.currentTarget.value)} />
            <NativeSelect
              label="Device that was worn"
              value={device}
              onChange={(event) => setDevice(event.currentTarget.value)}
              data={[
                { value: "", label: "None" },
                ...devices.map((each) => ({ value: each.id, label: `${each.name}, version ${each.version}` })),
              ]}
            />
            <Checkbox label="Evaluate at once" checked={evaluate} onChange={(event) => setEvaluate(event.currentTarget.checked)} mb={8} />
            <Button disabled={missing !== null} loading={busy} onClick={() => start(build)}>
              Make the study
            </Button>
          </Group>
          {missing && (
            <Text size="sm" c="dimmed" mt="xs">
              {missing}
            </Text>
          )}
        </Paper>
        {error !== null && <ProblemBox error={error} />}
      </Stack>
    </section>
  );
}

/** [s] of the day; null where no time is said. */
function secondsOf(time: string): number | null {
  if (!time) return null;
  const [hours = 0, minutes = 0, seconds = 0] = time.split(":").map(Number);
  return hours * 3600 + minutes * 60 + seconds;
}

function hindrance(name: string, used: { role: Role; motion: string }[], device: string): string | null {
  if (used.length === 0) return "Give at least one log a role.";
  if (!used.some(({ role }) => role === "identification")) return "One log at least has to identify the robot.";
  if (used.some(({ role, motion }) => MOVES.includes(role) && motion === "")) {
    return "Logs with and without the device are compared by motion: name the motion of each.";
  }
  if (used.some(({ role }) => role === "with_device") && !device) return "Choose the device that was worn.";
  return name.trim() ? null : "Give the study a name.";
}
