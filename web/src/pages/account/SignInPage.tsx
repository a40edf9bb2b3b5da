import { Button, PasswordInput, TextInput } from "@mantine/core";
import { useState } from "react";
import { Navigate, useSearchParams } from "react-router";

import { ownPath, signIn, useArrive, useSession } from "../../api/session";
import { useDeed } from "../../parts/useDeed";
import { Doorstep } from "./Doorstep";
import { ProviderButton } from "./ProviderButton";

export function Component() {
  const [search] = useSearchParams();
  const next = ownPath(search.get("next"));
  const { data: session } = useSession();
  const arrive = useArrive();
  const { start, busy, error } = useDeed();
  const [email, setEmail] = useState("");
  const [password, setPassword] = useState("");
  if (session?.set_up) return <Navigate to="/set-up" replace />;
  if (session && (!session.accounts || (session.account && !busy))) return <Navigate to={next} replace />;
  const submit = () =>
    start(async () => {
      await signIn({ email: email.trim(), password });
      await arrive(next);
    });
  return (
    <Doorstep title="Sign in" error={error} onSubmit={submit}>
      <TextInput
        label="E-mail address" type="email" name="email" autoComplete="username" required autoFocus value={email}
        onChange={(event) => setEmail(event.currentTarget.value)}
      />
      <PasswordInput
        label="Password" name="password" autoComplete="current-password" required value={password}
        onChange={(event) => setPassword(event.currentTarget.value)}
      />
      <Button type="submit" loading={busy}>
        Sign in
      </Button>
      <ProviderButton words="Sign in with" ask={{ purpose: "sign-in", next }} />
    </Doorstep>
  );
}
