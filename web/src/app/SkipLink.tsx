import { Button } from "@mantine/core";
import type { RefObject } from "react";

import styles from "./Shell.module.css";

/** A button and no link: an address with nothing but a fragment would be relative to the document's base. */
export function SkipLink({ target }: { target: RefObject<HTMLElement | null> }) {
  return (
    <Button className={styles.skip} onClick={() => target.current?.focus()}>
      Skip to the page
    </Button>
  );
}
