"""Samples near those that are marked."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

BoolArray = NDArray[np.bool_]


def around(marked: BoolArray, reach: int) -> BoolArray:
    """(T, K) whether any sample of the same column is marked no more than `reach` samples before or after."""
    samples = len(marked)
    count = np.zeros((samples + 1, *marked.shape[1:]), dtype=np.int32)
    np.cumsum(marked, axis=0, out=count[1:])
    at = np.arange(samples)
    behind, first = np.minimum(at + reach + 1, samples), np.maximum(at - reach, 0)
    return np.asarray(count[behind] > count[first])
