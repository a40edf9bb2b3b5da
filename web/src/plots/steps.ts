/** Moving about in time: what keys and buttons make of a window and a cursor. */

import type { Window } from "./Plot";
import { nearest } from "./series";

const SMALLEST = 1e-6; // of the whole: no closer

/** Narrower (factor < 1) or wider about a moment, which stays where it is; never beyond the whole. */
export function zoomed({ from, to }: Window, whole: Window, factor: number, about: number | null): Window {
  const centre = about !== null && about >= from && about <= to ? about : 0.5 * (from + to);
  const span = Math.min(Math.max((to - from) * factor, SMALLEST * (whole.to - whole.from)), whole.to - whole.from);
  return within({ from: centre - ((centre - from) / (to - from)) * span, to: centre + ((to - centre) / (to - from)) * span }, whole);
}

/** By a share of itself. */
export function panned({ from, to }: Window, whole: Window, share: number): Window {
  const by = share * (to - from);
  return within({ from: from + by, to: to + by }, whole);
}

/** Moved, not cut, to lie in the whole; times to a ten-thousandth of its length. */
export function within({ from, to }: Window, whole: Window): Window {
  const span = Math.min(to - from, whole.to - whole.from);
  const start = Math.min(Math.max(from, whole.from), whole.to - span);
  const places = Math.min(Math.max(4 - Math.floor(Math.log10(span || 1)), 0), 9);
  return { from: Number(start.toFixed(places)), to: Number((start + span).toFixed(places)) };
}

export function isWhole(window: Window, whole: Window): boolean {
  const close = 1e-4 * (whole.to - whole.from);
  return window.from - whole.from < close && whole.to - window.to < close;
}

/** The moment so many drawn samples on; from the middle of the window where there is none yet. */
export function stepped(times: ArrayLike<number>, { from, to }: Window, at: number | null, by: number): number {
  const start = at === null || at < from || at > to ? 0.5 * (from + to) : at;
  if (times.length === 0) return start;
  const k = Math.min(Math.max(nearest(times, start) + by, 0), times.length - 1);
  return Math.min(Math.max(times[k] as number, from), to);
}
