"""Stamps that jitter though samples were taken evenly: positions tell, for at the wrong times they are rough."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.logs import LOGS
from exogauge.logs.model import Log
from exogauge.logs.noise import noise_of
from exogauge.logs.resampling import is_even, uniform

Array = NDArray[np.float64]


def times_rougher(log: Log, resampled: Log, positions: Sequence[str]) -> tuple[float, float] | None:
    """Roughness of positions at the stamps and counted as even, each over the other; None where the clock is even or
    nothing can be told. log: without a gap. resampled: the same at its stamps."""
    if is_even(log.time) or not positions:
        return None
    as_stamped, as_counted = (_roughness(each, positions) for each in (resampled, log))
    return as_stamped / max(as_counted, 1e-300), as_counted / max(as_stamped, 1e-300)


def even_stamps(time: Array, positions: Array) -> Array:
    """(T,) [s] the clock on which samples were taken evenly between gaps, where positions (T, K) say that only their
    stamps jitter; else time as it is. What is too short to tell stays."""
    step = np.diff(time)
    edges = [0, *(np.flatnonzero(step > LOGS.late * np.median(step)) + 1), len(time)]
    parts = [(a, b) for a, b in pairwise(edges) if b - a >= LOGS.fewest_samples]
    names, even, tell = [f"q.{k}" for k in range(positions.shape[1])], time.copy(), list[tuple[float, float]]()
    for a, b in parts:
        line = np.polynomial.Polynomial.fit(np.arange(b - a), time[a:b], 1)
        even[a:b] = line(np.arange(b - a))
        log = Log("part", time[a:b], {name: positions[a:b, k] for k, name in enumerate(names)})
        told = times_rougher(log, uniform(log), names)
        tell += [told] * (b - a) if told is not None else []
    if not tell or np.median(tell, axis=0)[0] <= LOGS.rougher or not np.all(np.diff(even) > 0.0):
        return time
    return even if np.abs(even - time).max() < LOGS.joined * np.median(step) else time


def _roughness(log: Log, names: Sequence[str]) -> float:
    found = noise_of([log.channels[name] for name in names], log.rate_hz, 0.25 * log.rate_hz)
    return float(np.sqrt(sum(each.std**2 for each in found)))
