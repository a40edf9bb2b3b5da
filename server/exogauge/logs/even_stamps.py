"""Stamps that jitter though samples were taken evenly: positions tell, as they follow when a sample was taken."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.logs import LOGS
from exogauge.logs.derivatives import differentiate
from exogauge.logs.filtering import LowPass
from exogauge.logs.resampling import is_even

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Followed:
    """Which share of velocity times jitter is in the positions, and its std: 1 where samples were taken at their
    stamps, 0 where they were taken evenly and only the stamps jitter."""

    share: float
    std: float

    @property
    def at_stamps(self) -> bool:
        return abs(self.share - 1.0) < LOGS.nearly and self.share > LOGS.surely * self.std

    @property
    def evenly(self) -> bool:
        return abs(self.share) < LOGS.nearly and 1.0 - self.share > LOGS.surely * self.std


def jitter_followed(parts: Sequence[tuple[Array, Array]]) -> Followed | None:
    """parts: stretches without a gap, times (T,) [s] and positions (T, K). None where the clock is even, or nothing
    moves.

    Compared above the motion's band alone. White noise and an encoder's steps are in both readings alike: neither looks
    smoother for being interpolated.
    """
    from_samples = [_moments(time, positions) for time, positions in parts if not is_even(time)]
    if not from_samples:
        return None
    samples = sum(len(time) for time, _ in parts if not is_even(time))
    jitter, both, seen = np.sum(from_samples, axis=0)  # (K,) each: squares, products
    moves = (jitter > 0.0) & (seen > 0.0)
    if not moves.any():
        return None
    jitter, both, seen = jitter[moves], both[moves], seen[moves]
    share, weight = 0.0, samples / seen
    for _ in range(5):  # what noise each joint has depends on what is explained
        share = float((weight @ both) / (weight @ jitter))
        weight = samples / np.maximum(seen - 2.0 * share * both + share**2 * jitter, 1e-6 * seen)
    independent = 1.0 - 2.0 * LOGS.above_motion  # of all samples: as many as the band that is looked at holds
    return Followed(share, float(1.0 / np.sqrt(independent * (weight @ jitter))))


def even_stamps(time: Array, positions: Array) -> Array:
    """(T,) [s] the clock on which samples were taken evenly between gaps, where positions (T, K) say that only their
    stamps jitter; else time as it is. What is too short to tell stays."""
    step = np.diff(time)
    edges = [0, *(np.flatnonzero(step > LOGS.late * np.median(step)) + 1), len(time)]
    parts = [(a, b) for a, b in pairwise(edges) if b - a >= LOGS.fewest_samples]
    followed = jitter_followed([(time[a:b], positions[a:b]) for a, b in parts])
    if followed is None or not followed.evenly:
        return time
    even = time.copy()
    for a, b in parts:
        line = np.polynomial.Polynomial.fit(np.arange(b - a), time[a:b], 1)
        even[a:b] = line(np.arange(b - a))
    if not np.all(np.diff(even) > 0.0):
        return time
    return even if np.abs(even - time).max() < LOGS.joined * np.median(step) else time


def _moments(time: Array, positions: Array) -> Array:
    """(3, K) squares of velocity times jitter, products with the positions, squares of these, above the motion."""
    rate = (len(time) - 1) / float(time[-1] - time[0])
    late = time - np.linspace(time[0], time[-1], len(time))
    velocity = differentiate(LowPass(LOGS.in_motion * rate, rate).apply(positions), rate)
    low_pass = LowPass(LOGS.above_motion * rate, rate)
    jitter, seen = (each - low_pass.apply(each) for each in (velocity * late[:, None], positions))
    return np.array([np.sum(jitter**2, axis=0), np.sum(jitter * seen, axis=0), np.sum(seen**2, axis=0)])
