"""A low-pass of many channels whose output is wanted at some samples only, such as every tenth."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.logs.filtering import LowPass, _sections

Array = NDArray[np.float64]
IntArray = NDArray[np.intp]

LANES = 16  # channels that are filtered side by side: what is worked on stays in the cache


def low_passed_at(low_pass: LowPass, channels: Array, samples: IntArray) -> Array:
    """channels: (K, T), one after the other. samples: (n,) -> (n, K) `low_pass.apply(channels.T)[samples]`.

    The same steps in the same order; nothing between the wanted samples is written down.
    """
    from exogauge.loops.passes import both_ways, extended, picked

    beyond, length = low_pass.settle_samples, channels.shape[1]
    if low_pass.stored is not None or beyond >= length:
        return low_pass.apply(np.ascontiguousarray(channels.T))[samples]
    out = np.empty((len(samples), len(channels)))
    sections, steady = _sections(low_pass)
    for start in range(0, len(channels), LANES):
        some = channels[start : start + LANES]
        if not start or len(some) < LANES:
            buffer = np.empty((length + 2 * beyond, len(some)))
        extended(some, beyond, buffer)
        both_ways(sections, steady, buffer)
        picked(some, beyond, buffer, samples, out[:, start : start + LANES])
    if not np.isfinite(out).all():
        return low_pass.apply(np.ascontiguousarray(channels.T))[samples]  # says which value is none
    return out
