/** Paper is white: while the page is printed, a dark page is a light one. */

import { useEffect } from "react";

const SCHEME = "data-mantine-color-scheme";

export function usePrintInLight(): void {
  useEffect(() => {
    const page = document.documentElement;
    let before: string | null = null;
    const light = () => {
      before = page.getAttribute(SCHEME);
      page.setAttribute(SCHEME, "light");
    };
    const back = () => {
      if (before !== null) page.setAttribute(SCHEME, before);
      before = null;
    };
    window.addEventListener("beforeprint", light);
    window.addEventListener("afterprint", back);
    return () => {
      back();
      window.removeEventListener("beforeprint", light);
      window.removeEventListener("afterprint", back);
    };
  }, []);
}
