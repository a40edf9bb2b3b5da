import { Alert, Button } from "@mantine/core";
import { useSearchParams } from "react-router";

import type { Schemas } from "../../api/client";
import { goToProvider, reasonOf } from "../../api/oidc";
import { useSession } from "../../api/session";
import { ProblemBox } from "../../parts/ProblemBox";
import { useDeed } from "../../parts/useDeed";

/** To the provider that the service names, and why one came back from it without success. Nothing where there is none. */
export function ProviderButton({ words, ask }: { words: string; ask: Schemas["Begin"] }) {
  const { data: session } = useSession();
  const { start, busy, error } = useDeed();
  const [search] = useSearchParams();
  const reason = reasonOf(search.get("oidc"));
  if (!session?.oidc) return null;
  return (
    <>
      {reason && (
        <Alert color="red" title={`Not signed in by ${session.oidc}`} role="alert">
          {reason}
        </Alert>
      )}
      <Button variant="default" loading={busy} onClick={() => start(() => goToProvider(ask))}>
        {words} {session.oidc}
      </Button>
      {error !== null && <ProblemBox error={error} />}
    </>
  );
}
