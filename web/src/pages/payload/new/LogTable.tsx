import { Button, Checkbox, Group, NativeSelect, Table, Text } from "@mantine/core";

import { NumberField } from "../../../parts/NumberField";
import { placeOfFault } from "./StepFaults";
import { WideTable, number } from "../../../parts/WideTable";
import type { LogEntry, Role } from "./content";
import { wordsOf, type Fault } from "./faults";
import type { Drafted } from "./useDraft";

export const ROLES: { value: Role; label: string }[] = [
  { value: "postures", label: "Postures at rest" },
  { value: "excitation", label: "Excitation" },
  { value: "test", label: "Test: nothing touches" },
  { value: "contact", label: "Contact" },
];

/** Logs of these roles, and what of each is used. */
export function LogTable({ drafted, roles, faults, label }: { label: string; drafted: Drafted; roles: Role[]; faults: readonly Fault[] }) {
  const { draft, set, remove, look } = drafted;
  const logs = draft.content.logs;
  const shown = logs.filter(({ role }) => roles.includes(role));
  if (shown.length === 0) return null;
  const say = (log: LogEntry, change: Partial<LogEntry>) =>
    set((now) => ({ ...now, logs: now.logs.map((each) => (each.file.join() === log.file.join() ? { ...each, ...change } : each)) }));
  const rowsOf = (path: string) => look?.logs.find(({ file }) => file === path)?.rows;
  return (
    <WideTable label={label} columns={["Log", number("Rows"), "Role", "One row per posture", number("From", "s"), number("To", "s"), "What to know", "Take it out"]}>
      {shown.map((log) => {
        const name = log.file.join(" + ");
        const at = logs.indexOf(log);
        const wrong = faults.filter(({ file, column }) => log.file.includes(file ?? "") || column === `logs.${at}` || column?.startsWith(`logs.${at}.`));
        const span = log.span ?? [];
        const cut = (k: number, value: number | undefined) => {
          const next = [0, 1].map((each) => (each === k ? value : (span[each] ?? undefined)));
          say(log, { span: next.every((each) => each === undefined) ? undefined : next });
        };
        return (
          <Table.Tr key={name} data-log={name}>
            <Table.Th scope="row">{name}</Table.Th>
            <Table.Td data-number>{log.file.map((path) => rowsOf(path) ?? "…").join(" + ")}</Table.Td>
            <Table.Td>
              <NativeSelect
                size="xs"
                miw="10rem"
                aria-label={`Role of ${name}`}
                value={log.role}
                data={ROLES}
                onChange={(event) => {
                  const role = event.currentTarget.value as Role;
                  say(log, { role, ...(role !== "postures" && { each_row: undefined }) });
                }}
              />
            </Table.Td>
            <Table.Td>
              {log.role === "postures" && (
                <Checkbox
                  aria-label={`One row per posture in ${name}`}
                  checked={log.each_row ?? false}
                  onChange={(event) => say(log, { each_row: event.currentTarget.checked || undefined, ...(event.currentTarget.checked && { span: undefined }) })}
                />
              )}
            </Table.Td>
            {[0, 1].map((k) => (
              <Table.Td key={k}>
                <NumberField size="xs" w="5rem" disabled={log.each_row} aria-label={`${k ? "To" : "From"} [s] of ${name}`} placeholder={k ? "end" : "start"} value={span[k]} set={(value) => cut(k, value)} />
              </Table.Td>
            ))}
            <Table.Td miw="14rem">
              {wrong.map((fault, k) => (
                <Text key={k} size="xs" c="var(--mantine-color-error)">
                  {placeOfFault(fault)}
                  {wordsOf(fault)}
                </Text>
              ))}
            </Table.Td>
            <Table.Td>
              <Group gap={4} wrap="nowrap">
                <Button size="compact-xs" variant="default" aria-label={`Take out ${name}`} onClick={() => log.file.forEach(remove)}>
                  Take out
                </Button>
              </Group>
            </Table.Td>
          </Table.Tr>
        );
      })}
    </WideTable>
  );
}
