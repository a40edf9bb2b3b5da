/** One moment that every plot of a page, its tables and the 3D view look at. */

import { useEffect, useState, useSyncExternalStore } from "react";

export class Cursor {
  #time: number | null;
  readonly #listeners = new Set<() => void>();

  constructor(time: number | null = null) {
    this.#time = time;
  }

  get time(): number | null {
    return this.#time;
  }

  move(time: number | null): void {
    if (time === this.#time) return;
    this.#time = time;
    this.#listeners.forEach((listener) => listener());
  }

  readonly subscribe = (listener: () => void): (() => void) => {
    this.#listeners.add(listener);
    return () => this.#listeners.delete(listener);
  };
}

export function useTime(cursor: Cursor): number | null {
  return useSyncExternalStore(cursor.subscribe, () => cursor.time);
}

/** Whether it is anywhere: asked so, a part is not drawn anew with every move. */
export function useIsSet(cursor: Cursor): boolean {
  return useSyncExternalStore(cursor.subscribe, () => cursor.time !== null);
}

/** The time once it has rested for so long. */
export function useRestingTime(cursor: Cursor, forMs: number): number | null {
  const [rested, setRested] = useState(cursor.time);
  useEffect(() => {
    let waiting = 0;
    const wait = () => {
      window.clearTimeout(waiting);
      waiting = window.setTimeout(() => setRested(cursor.time), forMs);
    };
    wait();
    const stop = cursor.subscribe(wait);
    return () => {
      stop();
      window.clearTimeout(waiting);
    };
  }, [cursor, forMs]);
  return rested;
}
