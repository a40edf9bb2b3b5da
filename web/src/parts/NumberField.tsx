import { TextInput, type TextInputProps } from "@mantine/core";
import { useEffect, useState } from "react";

type Props = Omit<TextInputProps, "value" | "onChange"> & { value: number | null | undefined; set: (value: number | undefined) => void };

/** One number as somebody writes it: 0.05, 2e-5, 0,5. What is no number is told, and counts as nothing. */
export function NumberField({ value, set, error, ...rest }: Props) {
  const [text, write] = useState(asText(value));
  useEffect(() => {
    if (read(text) !== (value ?? undefined)) write(asText(value));
  }, [value]);
  const wrong = text.trim() !== "" && read(text) === undefined;
  return (
    <TextInput
      {...rest}
      inputMode="decimal"
      value={text}
      error={wrong ? "This is no number." : error}
      onChange={(event) => {
        write(event.currentTarget.value);
        set(read(event.currentTarget.value));
      }}
    />
  );
}

function asText(value: number | null | undefined): string {
  return value === null || value === undefined ? "" : String(value);
}

function read(text: string): number | undefined {
  const plain = text.trim().replace("−", "-").replace(",", ".");
  const value = Number(plain);
  return plain !== "" && Number.isFinite(value) ? value : undefined;
}
