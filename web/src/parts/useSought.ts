/** What a list is searched for, kept in the page's address, so that a link brings it back. */

import { useDebouncedCallback } from "@mantine/hooks";
import { useEffect, useRef, useState } from "react";
import { useSearchParams } from "react-router";

const PAUSE_MS = 300;

export type Sought = { typed: string; type: (words: string) => void; words: string; clear: () => void };

/** typed: what the box shows; words: what the list is asked for, once typing pauses; clear: whatever the list is chosen by. */
export function useSought(): Sought {
  const [words, setWords] = useInAddress("search");
  const [typed, setTyped] = useState(words);
  const written = useRef(words);
  useEffect(() => {
    if (words === written.current) return; // by ourselves
    written.current = words;
    setTyped(words);
  }, [words]);
  const [, setAddress] = useSearchParams();
  const later = useDebouncedCallback((text: string) => {
    written.current = text.trim();
    setWords(written.current);
  }, PAUSE_MS);
  const type = (text: string) => {
    setTyped(text);
    later(text);
  };
  const clear = () => {
    later.cancel();
    setTyped("");
    written.current = "";
    setAddress({}, { replace: true, preventScrollReset: true });
  };
  return { typed, type, words, clear };
}

/** Whether each of the words is in the name, as the service looks for it. */
export function isFound(words: string, name: string): boolean {
  return fold(words).split(/\s+/).every((word) => fold(name).includes(word));
}

function fold(text: string): string {
  return text.normalize("NFKC").toLowerCase().normalize("NFKC");
}

/** One text of the address; the others stay as they are. */
export function useInAddress(name: string): [string, (value: string) => void] {
  const [address, setAddress] = useSearchParams();
  const set = (value: string) =>
    setAddress(
      (before) => {
        const next = new URLSearchParams(before);
        if (value) next.set(name, value);
        else next.delete(name);
        return next;
      },
      { replace: true, preventScrollReset: true },
    );
  return [address.get(name) ?? "", set];
}
