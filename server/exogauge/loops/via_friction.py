"""How a band slides over its via points from one sample to the next: see `devices.laws.via_friction`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.loops.compiled import compiled

Array = NDArray[np.float64]

EDGE = 1e-12  # relative: how far beyond the strains at which it sticks a search begins


@compiled
def _march(w: float, first: int, L: Array, ratio: Array, held: Array, strain: Array, slip: Array) -> float:
    """Strains from segment `first` on if that has w; slip: how much slides from each to the next, the last must be 0.

    It grows with w, and jumps where the direction of a slip changes: there the band sticks. held: (S,) n_j so far.
    """
    moved = 0.0
    for j in range(first, L.shape[0]):
        strain[j] = w
        moved += held[j] - L[j] / (1.0 + w)
        slip[j] = moved
        if j < ratio.shape[0]:
            w = w * ratio[j] if moved > 0.0 else w / ratio[j]
    return moved


@compiled
def _slide(low: float, high: float, L: Array, ratio: Array, held: Array, strain: Array, work: Array) -> None:
    """(S,) the strains after a step in which something slides. low, high: they hold that of the first segment.

    Bisection for the first segment; where that ends in a jump at a via point, the band sticks there and all beyond is
    again a band of its own, whose first strain lies within what friction holds.
    """
    low_strain, high_strain, low_slip, high_slip = work[0], work[1], work[2], work[3]
    first, last = 0, L.shape[0] - 1
    while True:
        while True:
            w = 0.5 * (low + high)
            if not low < w < high:
                break
            if _march(w, first, L, ratio, held, low_strain, low_slip) > 0.0:
                high = w
            else:
                low = w
        _march(low, first, L, ratio, held, low_strain, low_slip)
        _march(high, first, L, ratio, held, high_strain, high_slip)
        j = first
        strain[j] = low
        while j < last and (low_slip[j] > 0.0) == (high_slip[j] > 0.0):
            j += 1
            strain[j] = low_strain[j]
        if j == last:
            return
        # an end that sticks to the last digit slides neither way: just beyond it the direction is sure again
        low, high, first = low_strain[j + 1] * (1.0 - EDGE), high_strain[j + 1] * (1.0 + EDGE), j + 1


@compiled
def slide_along(lengths: Array, ratios: Array, l_0: float, strains: Array) -> None:
    """Fills strains (T, S) with L/n - 1, 0 where slack. lengths: (T, S) [m]. ratios: (T, S-1) e^{μφ}."""
    samples, segments = lengths.shape
    n, work = np.empty(segments), np.empty((4, segments))
    taut = False
    for t in range(samples):
        L, ratio, w = lengths[t], ratios[t], strains[t]
        total, most = 0.0, 1.0
        for length in L:
            total += length
        for r in ratio:
            most *= r
        even = total / l_0 - 1.0
        if even <= 0.0:
            taut = False
            continue
        holds = taut
        for j in range(segments):
            w[j] = L[j] / n[j] - 1.0 if taut else even
            holds = holds and w[j] > 0.0
            if j > 0:
                holds = holds and w[j] <= ratio[j - 1] * w[j - 1] and w[j - 1] <= ratio[j - 1] * w[j]
        if taut and not holds:
            _slide(even / most, even * most, L, ratio, n, w, work)
        if not holds:
            for j in range(segments):
                n[j] = L[j] / (1.0 + w[j])
        taut = True
