"""Where a recording stood still: postures for the static stage."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.payload_static import USUAL, Standing

Array = NDArray[np.float64]


def find_holds(time: Array, angles: Array, noise: float, criteria: Standing = USUAL) -> list[tuple[float, float]]:
    """Spans (from, to) [s] in which no angle changes. angles: (T, J) [rad], or (T, 9) entries of rotations.

    noise: [rad] std of a sample. A window's two halves must have the same mean, within what noise allows.
    """
    period = float(np.median(np.diff(time)))
    half = max(int(round(criteria.window_s / 2 / period)), 1)
    if len(time) <= 2 * half:
        return []
    sums = np.concatenate([np.zeros((1, angles.shape[1])), np.cumsum(angles - angles[0], axis=0)])
    before = (sums[half:-half] - sums[: -2 * half]) / half
    after = (sums[2 * half :] - sums[half:-half]) / half
    speed = np.abs(after - before).max(axis=1) / (half * period)
    limit = criteria.slowest + criteria.noises * noise * np.sqrt(2.0 / half) / (half * period)
    still = np.zeros(len(time), dtype=bool)
    still[half : half + len(speed)] = speed < limit
    gaps = np.flatnonzero(np.diff(time) > 5 * period)
    still[gaps] = False
    edges = np.flatnonzero(np.diff(np.concatenate([[0], still.astype(np.int8), [0]])))
    spans = [(float(time[a]), float(time[b - 1])) for a, b in edges.reshape(-1, 2)]
    edge, shortest = criteria.swinging_s, criteria.shortest_hold_s
    return [(a + edge, b - edge) for a, b in spans if b - a - 2 * edge >= shortest - 1e-9]
