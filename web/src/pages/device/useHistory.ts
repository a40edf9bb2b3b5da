/** A value that can be changed, and changed back. */

import { useCallback, useState } from "react";

type Past<T> = { done: T[]; now: T; undone: T[]; mark: string; at: number };

const ONE_STEP_MS = 800; // what is changed at one place within this time is one step

export type History<T> = {
  now: T;
  set: (next: T, mark: string) => void;
  undo: () => void;
  redo: () => void;
  reset: () => void;
  canUndo: boolean;
  canRedo: boolean;
};

/** mark: names what is changed, so that a slider's journey is one step. */
export function useHistory<T>(start: T): History<T> {
  const [past, setPast] = useState<Past<T>>({ done: [], now: start, undone: [], mark: "", at: 0 });
  const set = useCallback((next: T, mark: string) => {
    setPast((was) => {
      const same = was.mark === mark && Date.now() - was.at < ONE_STEP_MS;
      return { done: same ? was.done : [...was.done, was.now], now: next, undone: [], mark, at: Date.now() };
    });
  }, []);
  const undo = useCallback(() => {
    setPast((was) => {
      const before = was.done.at(-1);
      if (before === undefined) return was;
      return { done: was.done.slice(0, -1), now: before, undone: [was.now, ...was.undone], mark: "", at: 0 };
    });
  }, []);
  const redo = useCallback(() => {
    setPast((was) => {
      const [after, ...later] = was.undone;
      if (after === undefined) return was;
      return { done: [...was.done, was.now], now: after, undone: later, mark: "", at: 0 };
    });
  }, []);
  const reset = useCallback(() => {
    setPast((was) => ({ done: [...was.done, was.now], now: was.done[0] ?? was.now, undone: [], mark: "", at: 0 }));
  }, []);
  return { now: past.now, set, undo, redo, reset, canUndo: past.done.length > 0, canRedo: past.undone.length > 0 };
}
