import { Button, TextInput } from "@mantine/core";
import { useState } from "react";
import { Navigate } from "react-router";

import { setUp, useArrive, useSession } from "../../api/session";
import { useDeed } from "../../parts/useDeed";
import { Doorstep } from "./Doorstep";
import { NewPassword } from "./NewPassword";

const EMPTY = { code: "", email: "", name: "", password: "", lab: "" };

export function Component() {
  const { data: session } = useSession();
  const arrive = useArrive();
  const { start, busy, error } = useDeed();
  const [typed, setTyped] = useState(EMPTY);
  if (session && !session.set_up && !busy) return <Navigate to="/studies" replace />;
  const field = (name: keyof typeof EMPTY) => ({
    value: typed[name],
    required: true,
    onChange: (event: { currentTarget: { value: string } }) => {
      const { value } = event.currentTarget;
      setTyped((before) => ({ ...before, [name]: value }));
    },
  });
  const submit = () =>
    start(async () => {
      await setUp({ ...typed, email: typed.email.trim() });
      await arrive("/studies");
    });
  return (
    <Doorstep
      title="Set up" error={error} onSubmit={submit}
      lead="The first account runs this installation, and is admin of its first lab. What is stored here already is that lab’s."
    >
      <TextInput
        label="Code" autoComplete="off" autoFocus {...field("code")}
        description="The server said it where it was started, and keeps it in the file set-up-code of its data folder."
      />
      <TextInput label="Your name" autoComplete="name" {...field("name")} />
      <TextInput label="E-mail address" type="email" autoComplete="username" {...field("email")} />
      <NewPassword value={typed.password} onChange={(password) => setTyped((before) => ({ ...before, password }))} />
      <TextInput label="Name of your lab" autoComplete="organization" {...field("lab")} />
      <Button type="submit" loading={busy}>
        Make the account
      </Button>
    </Doorstep>
  );
}
