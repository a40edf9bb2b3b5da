import type { ReactNode } from "react";
import { Navigate, useLocation } from "react-router";

import { useSession } from "../api/session";
import { Loading } from "../parts/Loading";

const DOORSTEPS = ["sign-in", "set-up", "invited", "published"];

/** The page, for who may see it; the way to sign in for others. A service that does not answer is the banner's business. */
export function LetIn({ children }: { children: ReactNode }) {
  const { data: session, isPending } = useSession();
  const { pathname, search, hash } = useLocation();
  if (isPending) return <Loading what="the page" />;
  const outside = session?.accounts && !session.account;
  if (outside && !DOORSTEPS.includes(pathname.split("/")[1] ?? "")) {
    const back = encodeURIComponent(pathname + search + hash);
    return <Navigate to={session.set_up ? "/set-up" : `/sign-in?next=${back}`} replace />;
  }
  return children;
}
