import { Table } from "@mantine/core";

import type { Preview } from "../../api/imports";
import type { ProblemError } from "../../api/refusal";
import { WideTable } from "../../parts/WideTable";
import { NOTHING, type Choice, type Whole } from "./choices";
import { ColumnRow } from "./ColumnRow";

type Props = {
  preview: Preview;
  whole: Whole;
  set: (whole: Whole) => void;
  joints: string[];
  sensors: string[];
  errors: ProblemError[];
};

/** Every column with its first values, and what it is. */
export function ColumnTable({ preview, whole, set, joints, sensors, errors }: Props) {
  const change = (name: string, choice: Choice) => {
    const columns = { ...whole.columns, [name]: choice };
    if (choice.means === "t") {
      for (const [other, each] of Object.entries(columns)) if (other !== name && each.means === "t") columns[other] = NOTHING;
    }
    set({ ...whole, columns });
  };
  return (
    <WideTable label="Columns of the file" mostHeight="40rem" tight>
      <Table.Thead>
        <Table.Tr>
          <Table.Th>Column</Table.Th>
          <Table.Th>First values</Table.Th>
          <Table.Th data-number>Smallest, largest</Table.Th>
          <Table.Th>Measures</Table.Th>
          <Table.Th>Of</Table.Th>
          <Table.Th>Unit</Table.Th>
          <Table.Th>Sign</Table.Th>
          <Table.Th>Side</Table.Th>
          <Table.Th>What to know</Table.Th>
        </Table.Tr>
      </Table.Thead>
      <Table.Tbody>
        {preview.columns.map((column) => (
          <ColumnRow
            key={column.name}
            column={column}
            choice={whole.columns[column.name] ?? NOTHING}
            set={(choice) => change(column.name, choice)}
            joints={joints}
            sensors={sensors}
            errors={errors.filter((error) => error.column === column.name)}
          />
        ))}
      </Table.Tbody>
    </WideTable>
  );
}
