import type { Preview } from "../../api/imports";
import type { ProblemError } from "../../api/refusal";
import { number, WideTable } from "../../parts/WideTable";
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
    <WideTable
      label="Columns of the file"
      mostHeight="40rem"
      tight
      columns={["Column", "First values", number("Smallest, largest"), "Measures", "Of", "Unit", "Sign", "Side", "What to know"]}
    >
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
    </WideTable>
  );
}
