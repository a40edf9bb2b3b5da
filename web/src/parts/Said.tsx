import { Code } from "@mantine/core";

/** A sentence of the service's: what it sets in backquotes is a name out of a file. */
export function Said({ words }: { words: string }) {
  return words.split(/`([^`]+)`/).map((part, k) => (k % 2 ? <Code key={k}>{part}</Code> : part));
}
