import { useElementSize } from "@mantine/hooks";
import { useEffect, useRef } from "react";
import { Link, useSearchParams } from "react-router";

import type { SectionLink } from "./sections";
import styles from "./SectionNav.module.css";

type Props = { studyId: string; sections: SectionLink[]; present: string };

/** Links to the parts of the review; the chosen job and the view of the plots go along. */
export function SectionNav({ studyId, sections, present }: Props) {
  const [search] = useSearchParams();
  const { ref: room, width } = useElementSize();
  const list = useRef<HTMLUListElement>(null);
  useEffect(() => {
    const [links, now] = [list.current, list.current?.querySelector<HTMLElement>("[aria-current]")];
    if (links && now) links.scrollLeft = now.offsetLeft - links.offsetLeft - (links.clientWidth - now.offsetWidth) / 2;
  }, [present, sections.length, width]);
  if (sections.length < 2) return null;
  return (
    <nav aria-label="Parts of the review" className={styles.nav} ref={room}>
      <ul className={styles.links} ref={list}>
        {sections.map(({ key, name }) => (
          <li key={key}>
            <Link
              to={{ pathname: `/studies/${studyId}/${key}`, search: search.toString() }}
              className={styles.link}
              aria-current={key === present ? "page" : undefined}
              preventScrollReset
            >
              {name}
            </Link>
          </li>
        ))}
      </ul>
    </nav>
  );
}
