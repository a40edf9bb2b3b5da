/** What was typed on a page, over a sign-in: while a guard is in the way the page is left, and loaded anew afterwards. */

import { useEffect, useRef, useState, type Dispatch, type SetStateAction } from "react";

import { isSignedOut } from "../api/reachable";

const STORE = "exogauge-kept";

type Kept = Record<string, unknown>;

const present = new Map<string, () => unknown>();
const before: Kept = taken();

window.addEventListener("pagehide", () => {
  if (!isSignedOut()) return;
  const kept = { ...before, ...Object.fromEntries([...present].map(([name, value]) => [name, value()])) };
  try {
    sessionStorage.setItem(STORE, JSON.stringify(kept));
  } catch {
    // this browser keeps nothing
  }
});

function taken(): Kept {
  try {
    const kept = sessionStorage.getItem(STORE);
    sessionStorage.removeItem(STORE);
    return kept ? (JSON.parse(kept) as Kept) : {};
  } catch {
    return {};
  }
}

/** Keeps `value` under the page's path and a name; gives `restore` what was kept there, once. */
export function useKeep<T>(name: string, value: T, restore: (kept: T) => void): void {
  const latest = useRef(value);
  latest.current = value;
  useEffect(() => {
    const key = `${window.location.pathname} ${name}`;
    if (key in before) restore(before[key] as T);
    delete before[key];
    present.set(key, () => latest.current);
    return () => void present.delete(key);
  }, [name]);
}

/** A state that is kept. */
export function useKept<T>(name: string, start: T): [T, Dispatch<SetStateAction<T>>] {
  const [value, set] = useState(start);
  useKeep(name, value, set);
  return [value, set];
}
