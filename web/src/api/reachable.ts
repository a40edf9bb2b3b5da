/** Whether the service answers, and lets us in, as the last request found it. */

import { useSyncExternalStore } from "react";

import { Refusal } from "./refusal";

const TRIES = 3; // a guard that lets us read may still forbid what is asked for

let away: Refusal | null = null;
const listeners = new Set<() => void>();

export function answered(): void {
  tell(null);
}

export function failed(refusal: Refusal): void {
  tell(refusal.away || refusal.signedOut ? refusal : null);
}

function tell(now: Refusal | null): void {
  if (away?.problem.type === now?.problem.type && away?.status === now?.status) return;
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

export function isSignedOut(): boolean {
  return away?.signedOut ?? false;
}

/** What `ask` gives; while somebody has to sign in, it waits for that, and asks again. */
export async function onceSignedIn<T>(ask: () => Promise<T>, signal: AbortSignal): Promise<T> {
  for (let tries = 1; ; tries++) {
    try {
      return await ask();
    } catch (error) {
      if (!(error instanceof Refusal && error.signedOut) || tries === TRIES) throw error;
      await signIn(signal);
    }
  }
}

function signIn(signal: AbortSignal): Promise<void> {
  return new Promise((resolve, reject) => {
    const look = () => {
      if (isSignedOut()) return;
      stop();
      resolve();
    };
    const stop = subscribe(look);
    signal.addEventListener("abort", () => {
      stop();
      reject(new DOMException("stopped", "AbortError"));
    });
    look();
  });
}
