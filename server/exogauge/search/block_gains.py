"""How surely an error falls, from the sums of what is gained in parts of the data that count as independent."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.stats import rankdata

Array = NDArray[np.float64]

FEWEST = 5  # parts from which ranks tell anything


def sureness(gains: Array) -> float:
    """Standard errors by which parts gain: of their mean, or of their signed ranks where those say more in the same
    direction. A few parts that gain much make the mean's own error large, although nearly all parts gain. NaN: a part
    of which nothing is known."""
    gains = gains[np.isfinite(gains)]
    if len(gains) < 2:
        return 0.0
    error = float(gains.std(ddof=1)) / np.sqrt(len(gains))
    by_mean = float(gains.mean()) / error if error > 0.0 else 0.0
    told = gains[gains != 0.0]
    n = len(told)
    if n < FEWEST:
        return by_mean
    positive = float(rankdata(np.abs(told))[told > 0.0].sum())
    by_rank = (positive - n * (n + 1) / 4.0) / float(np.sqrt(n * (n + 1) * (2 * n + 1) / 24.0))
    return max(by_mean, by_rank) if by_mean > 0.0 else min(by_mean, by_rank)


def summed(values: Array, part: NDArray[np.intp]) -> Array:
    """(parts,) sums over those that hold anything. values, part: (N,)."""
    places, number = np.unique(part, return_inverse=True)
    return np.asarray(np.bincount(number, values, minlength=len(places)), dtype=np.float64)
