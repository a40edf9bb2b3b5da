import { PasswordInput } from "@mantine/core";

type Props = { value: string; onChange: (value: string) => void; label?: string };

export function NewPassword({ value, onChange, label = "Password" }: Props) {
  return (
    <PasswordInput
      label={label} name="new-password" autoComplete="new-password" required minLength={15} value={value}
      description="At least 15 letters; several words make a good one."
      onChange={(event) => onChange(event.currentTarget.value)}
    />
  );
}
