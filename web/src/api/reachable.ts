/** Whether the service answers, as the last request found it. */

import { useSyncExternalStore } from "react";

import { Refusal } from "./refusal";

let away: Refusal | null = null;
const listeners = new Set<() => void>();

export function answered(): void {
  tell(null);
}

export function failed(refusal: Refusal): void {
  if (refusal.away) tell(refusal);
  else tell(null);
}

function tell(now: Refusal | null): void {
  if (away?.status === now?.status) return;
  away = now;
  listeners.forEach((listener) => listener());
}

function subscribe(listener: () => void): () => void {
  listeners.add(listener);
  return () => listeners.delete(listener);
}

/** null while the service answers, else why it does not. */
export function useAway(): Refusal | null {
  return useSyncExternalStore(subscribe, () => away);
}
