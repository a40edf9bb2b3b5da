import { useQuery, useQueryClient } from "@tanstack/react-query";

import { answer, api, type Schemas } from "./client";
import { useSession } from "./session";

/** Leaves this page for the provider, which sends the browser back. */
export async function goToProvider(body: Schemas["Begin"]) {
  const { url } = await answer(api.POST("/api/v1/oidc/begin", { body }));
  window.location.assign(url);
  await new Promise(() => {}); // the page goes
}

/** Why the browser came back without being signed in, by the word in the address. */
const REASONS: Record<string, string> = {
  denied: "You have not agreed to sign in there.",
  expired: "This took longer than ten minutes, or was begun in another browser. Try again.",
  unknown: "This login belongs to no account here. Open the link of your invitation and go on with it there, or sign in with your password and link it on the page Account.",
  locked: "This account is locked; ask who runs the service.",
  taken: "This login is linked with another account.",
  invitation: "The invitation is not known, was used or withdrawn, or has run out; ask for another.",
  other: "The address of the invitation has an account here: sign in with its password, and link this login on the page Account.",
  failed: "The provider’s answer could not be believed; the server’s log says why.",
};

export const reasonOf = (word: string | null) => (word === null ? null : (REASONS[word] ?? REASONS.failed!));

export function useIdentities() {
  const { data: session } = useSession();
  return useQuery({
    queryKey: ["identities"],
    queryFn: ({ signal }) => answer(api.GET("/api/v1/account/identities", { signal })),
    enabled: Boolean(session?.oidc && session.account),
  });
}

export function useUnlink() {
  const cache = useQueryClient();
  return async (identity_id: string) => {
    await answer<unknown>(api.DELETE("/api/v1/account/identities/{identity_id}", { params: { path: { identity_id } } }));
    await cache.invalidateQueries({ queryKey: ["identities"] });
  };
}
