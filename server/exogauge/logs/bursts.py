"""Stamps that came in bursts: messages wait and arrive together, though each was measured on an even clock.

A message can be late, never early. So the clock is the lower envelope of the stamps over the messages' numbers: a burst
returns to it, because the jump before it is as long as the messages that waited, and a gap, in which nothing was
measured, never does. Only the first is evened out.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.logs import LOGS
from exogauge.logs.model import Array, Note


def evened(time: NDArray[Any], unit_s: float = 1.0) -> tuple[NDArray[Any], Note | None]:
    """time: (T,) stamps in any unit, finite. The even stamps that they follow, with what was done said; or, where they
    came in no bursts, time as it is and None. Whole numbers stay whole. unit_s: of time [s], for the words.

    Between gaps the clock is even, and a gap stays one.
    """
    fewest, times = 20, 4  # samples in a window, and how many times the longest burst: it holds a message on time
    if time.size < 2 * fewest:
        return time, None
    first = time[0]
    stamps = np.asarray(time - first, np.float64)
    steps = np.diff(stamps)
    if not (steps < 1e-9 * np.abs(steps).max()).any() and not _many_tiny(steps):
        return time, None
    period = _period(stamps)
    tiny = steps < LOGS.tiny * period
    if (steps < -LOGS.tiny * period).any() or tiny.mean() < LOGS.tiny_share:
        return time, None
    window = max(fewest, times * (_longest(tiny) + 1))
    if 2 * window > time.size:
        return time, None
    late = stamps - period * np.arange(time.size)
    behind, ahead = _lowest_before(late, window), _lowest_before(late[::-1], window)[::-1]
    moved = ahead[1:] - behind[:-1]
    moved[: window - 1] = moved[-(window - 1) :] = 0.0  # no whole window there, and perhaps no message on time
    if moved.min() < -LOGS.envelope * period:  # more messages than the clock has ticks
        return time, None
    edges = [0, *(_gaps(moved > LOGS.envelope * period, window) + 1), time.size]
    even = np.empty_like(stamps)
    for start, stop in pairwise(edges):
        even[start:stop] = _beneath(stamps[start:stop], period, window)
    if not (np.diff(even) > 0).all():
        return time, None
    worst = float(np.max(stamps - even)) * unit_s
    detail = (
        f"stamps come in bursts: {tiny.mean():.0%} of them follow the one before at once, others up to {worst:.3g} s "
        f"late. They are replaced by the even clock beneath them, {1.0 / (np.median(np.diff(even)) * unit_s):.4g} Hz"
    )
    advice = "log the time at which each sample was measured, not that of its arrival"
    whole = time.dtype.kind in "iu"
    return (first + np.rint(even).astype(np.int64) if whole else first + even), Note("bursts_evened", detail, advice)


def _beneath(stamps: Array, period: float, window: int) -> Array:
    """The even clock through the messages that were on time: the earliest of each window. period: roughly."""
    number = np.arange(stamps.size)
    starts = np.arange(0, max(1, stamps.size - window + 1), window)
    for _ in range(3):  # the drift of a rough period hides at first which was earliest
        own = stamps - period * number
        earliest = np.array([start + int(np.argmin(own[start : start + window])) for start in starts])
        if earliest.size > 2:
            period += np.polyfit(earliest, own[earliest], 1)[0]
    own = stamps - period * number
    return np.asarray(period * number + own.min())


def _many_tiny(steps: Array) -> bool:
    return bool((steps < LOGS.tiny * steps.mean()).mean() > LOGS.tiny_share)


def _period(stamps: Array) -> float:
    """Median slope over a tenth of the stamps: bursts average out, and a gap lies in few of them."""
    every = 1000  # windows that a slope is taken over, at most
    lag = max(1, stamps.size // 10)
    slopes = (stamps[lag:] - stamps[:-lag]) / lag
    return float(np.median(slopes[:: max(1, slopes.size // every)]))


def _longest(flags: NDArray[np.bool_]) -> int:
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    return int((edges[1::2] - edges[::2]).max(initial=0))


def _lowest_before(values: Array, window: int) -> Array:
    """(T,) lowest of the last `window` values, the present one included."""
    padded = np.concatenate([np.full(window - 1, np.inf), values])
    return np.asarray(np.lib.stride_tricks.sliding_window_view(padded, window).min(axis=1))


def _gaps(moved: NDArray[np.bool_], window: int) -> NDArray[np.intp]:
    """The first place of each run: the envelope looks moved until the window has passed."""
    places = np.flatnonzero(moved)
    return places[np.diff(places, prepend=-window - 1) > 1]
