import { Button, Group } from "@mantine/core";

import type { Preview } from "../../api/imports";
import { count } from "../../parts/size";
import { choicesOf, NOTHING, type Mapping, type Whole } from "./choices";

type Props = { preview: Preview; whole: Whole; set: (whole: Whole) => void };

/** What is said of many columns at once. */
export function MappingTools({ preview, whole, set }: Props) {
  const take = (mapping: unknown) => {
    const made = choicesOf(mapping as Mapping, preview);
    if (made) set(made);
  };
  const open = preview.columns.filter(({ name }) => (whole.columns[name]?.means ?? "") === "");
  const proposed = choicesOf(preview.proposal as Mapping, preview)?.columns ?? {};
  const guesses = open.filter(({ name }) => (proposed[name]?.means ?? "") !== "");
  const takeGuesses = () => {
    const added = Object.fromEntries(guesses.map(({ name }) => [name, proposed[name] ?? NOTHING]));
    set({ ...whole, columns: { ...whole.columns, ...added } });
  };
  const ignoreRest = () => {
    const left = Object.fromEntries(open.map(({ name }) => [name, { ...NOTHING, means: "ignore" as const }]));
    set({ ...whole, columns: { ...whole.columns, ...left } });
  };
  return (
    <Group gap="xs">
      {preview.remembered && (
        <Button variant="default" size="xs" onClick={() => take(preview.remembered)}>
          As kept for the robot
        </Button>
      )}
      <Button variant="default" size="xs" onClick={() => take(preview.mapping)}>
        Only what is sure
      </Button>
      {guesses.length > 0 && (
        <Button variant="default" size="xs" onClick={takeGuesses}>
          Take {count(guesses.length, "suggestion")}
        </Button>
      )}
      {open.length > 0 && (
        <Button variant="default" size="xs" onClick={ignoreRest}>
          {open.length === 1 ? "Ignore the open one" : `Ignore the ${open.length} open ones`}
        </Button>
      )}
    </Group>
  );
}
