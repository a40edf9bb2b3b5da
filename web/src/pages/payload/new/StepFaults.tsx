import { Alert, List, Text } from "@mantine/core";

import { Said } from "../../../parts/Said";
import { fieldOf, isOpen, wordsOf, type Fault } from "./faults";

/** What keeps a step from being done: what is wrong with its place, and what is only not said yet. */
export function StepFaults({ faults }: { faults: readonly Fault[] }) {
  const wrong = faults.filter((fault) => !isOpen(fault));
  const open = [...new Set(faults.filter(isOpen).map(({ column }) => fieldOf(column)))];
  return (
    <>
      {wrong.length > 0 && (
        <Alert role="alert" color="red" variant="outline" title="This does not fit yet">
          <List size="sm">
            {wrong.map((fault, k) => (
              <List.Item key={k}>
                <strong>{placeOfFault(fault)}</strong>
                <Said words={wordsOf(fault)} />
              </List.Item>
            ))}
          </List>
        </Alert>
      )}
      {open.length > 0 && (
        <Text size="sm" data-testid="open">
          Still to be said: {open.join(", ")}.
        </Text>
      )}
    </>
  );
}

/** `logs/a.csv, row 3, column fx: ` */
export function placeOfFault({ file, row, column }: Fault): string {
  if (file === "payload.yaml" || !file) return column ? `${column}: ` : "";
  const parts = [file];
  if (row) parts.push(`row ${row}`);
  if (column) parts.push(`column ${column}`);
  return `${parts.join(", ")}: `;
}
