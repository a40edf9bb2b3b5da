import { Button, Text, TextInput } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { useState } from "react";
import { useLocation } from "react-router";

import { acceptInvitation, lookAtInvitation, signOut, useArrive, useSession } from "../../api/session";
import { Empty } from "../../parts/Empty";
import { LinkButton } from "../../parts/LinkButton";
import { Loading } from "../../parts/Loading";
import { ProblemBox } from "../../parts/ProblemBox";
import { useDeed } from "../../parts/useDeed";
import { Doorstep } from "./Doorstep";
import { NewPassword } from "./NewPassword";
import { ProviderButton } from "./ProviderButton";

/** The code stands behind the `#`: no server on the way sees it, and no log keeps it. */
export function Component() {
  const code = useLocation().hash.slice(1);
  const { data: session } = useSession();
  const { data: invited, error: refused } = useQuery({
    queryKey: ["invited", code],
    queryFn: () => lookAtInvitation(code),
    enabled: code !== "",
    retry: false,
  });
  const arrive = useArrive();
  const { start, busy, error } = useDeed();
  const [name, setName] = useState("");
  const [password, setPassword] = useState("");
  if (code === "")
    return (
      <Empty title="An invitation has a longer address" heading={1}>
        <p>The part behind the # is missing. Open the link as it was given to you.</p>
      </Empty>
    );
  if (refused) return <ProblemBox error={refused} />;
  if (!invited || !session) return <Loading what="the invitation" />;
  const me = session.account?.email;
  const here = `/invited#${code}`;
  const accept = (body: { name?: string; password?: string }) =>
    start(async () => {
      await acceptInvitation({ code, ...body });
      await arrive("/studies");
    });
  const lead = `You are invited to the lab ${invited.lab} as ${invited.role}, by the address ${invited.email}.`;
  if (me === invited.email)
    return (
      <Doorstep title="Invitation" lead={lead} error={error} onSubmit={() => accept({})}>
        <Button type="submit" loading={busy}>
          Join {invited.lab}
        </Button>
      </Doorstep>
    );
  if (me)
    return (
      <Doorstep title="Invitation" lead={lead} error={error} onSubmit={() => start(async () => { await signOut(); await arrive(here); })}>
        <Text>You are signed in as {me}.</Text>
        <Button type="submit" loading={busy}>
          Sign out, and go on as {invited.email}
        </Button>
      </Doorstep>
    );
  if (invited.has_account)
    return (
      <Empty title="Invitation" heading={1}>
        <Text>{lead} This address has an account here.</Text>
        <LinkButton to={`/sign-in?next=${encodeURIComponent(here)}`}>Sign in</LinkButton>
      </Empty>
    );
  return (
    <Doorstep title="Invitation" lead={lead} error={error} onSubmit={() => accept({ name, password })}>
      <TextInput label="Your name" autoComplete="name" required autoFocus value={name} onChange={(event) => setName(event.currentTarget.value)} />
      <NewPassword value={password} onChange={setPassword} />
      <Button type="submit" loading={busy}>
        Make the account and join
      </Button>
      <ProviderButton words="Or go on with" ask={{ purpose: "invitation", next: "/studies", code }} />
    </Doorstep>
  );
}
