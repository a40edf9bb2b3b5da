import { useEffect, useRef } from "react";
import { Outlet, ScrollRestoration, useLocation, useNavigation } from "react-router";

import { Header } from "./Header";
import { LetIn } from "./LetIn";
import { SkipLink } from "./SkipLink";
import styles from "./Shell.module.css";
import { UnreachableBanner } from "./UnreachableBanner";

/** What stands around every page. A new page takes the focus, so that a screen reader begins there. */
export function Shell() {
  const main = useRef<HTMLElement>(null);
  const before = useRef("/");
  const { pathname } = useLocation();
  const loading = useNavigation().state === "loading";
  const page = pathname.split("/").slice(0, 3).join("/"); // tabs below a page move no focus

  useEffect(() => {
    if (before.current !== "/" && before.current !== page) main.current?.focus({ preventScroll: true });
    before.current = page;
  }, [page]);

  return (
    <>
      <SkipLink target={main} />
      <Header />
      <UnreachableBanner />
      <main ref={main} tabIndex={-1} className={styles.main} aria-busy={loading}>
        <LetIn>
          <Outlet />
        </LetIn>
      </main>
      <ScrollRestoration getKey={(location) => location.pathname} />
    </>
  );
}
