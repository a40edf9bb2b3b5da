import { Text } from "@mantine/core";
import { createContext, use, type ReactNode } from "react";

import { useSession } from "../api/session";

/** Whose a thing is that one only reads: the name of the lab that shares it. */
export const SharedBy = createContext<string | null>(null);

/** Why one may change nothing here; null where one may. */
export function useWhyNot(): string | null {
  const { data: session } = useSession();
  const lab = use(SharedBy);
  if (lab !== null) return `The lab ${lab} shares this for reading: only its members change it.`;
  if (session?.accounts && session.lab?.role === "viewer")
    return `You are viewer of the lab ${session.lab.name}, and read only. An admin of it can make you a member.`;
  return null;
}

type Props = { told?: boolean; children: ReactNode };

/** What changes something, for whoever may. Others see nothing of it, or with `told` the reason in its place. */
export function ForMembers({ told = false, children }: Props) {
  const why = useWhyNot();
  if (why === null) return children;
  return told ? (
    <Text size="sm" c="dimmed" data-testid="why-not">
      {why}
    </Text>
  ) : null;
}
