"""How much every joint counts where bands are fitted: how large its errors are, and how long they last."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.support.band_rows import WearLogs
from exogauge.support.coloured import autocovariance

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

LEAST_SIGMA = 1e-3  # [N·m] of a joint on which nothing was found where there is nothing


def weights(logs: WearLogs, sigma: Array, memory: Array) -> tuple[Array, float]:
    """(N, D) 1/(σ² memory) of the samples that count, and how many independent errors they are."""
    return logs.used / (sigma**2 * memory), float(np.sum(logs.used / memory))


def memories(logs: WearLogs, e: Array) -> Array:
    """(D,) samples of a joint's residual that count as one: their integral correlation time, mean over the logs."""
    result = np.ones(e.shape[1])
    for joint in range(e.shape[1]):
        found = []
        for log in range(len(logs.logs)):
            own = (logs.log == log) & logs.used[:, joint]
            if own.sum() > 10:
                whole = logs.log == log
                c = autocovariance(np.where(own, e[:, joint], 0.0)[whole], own[whole])
                found.append((1.0 + 2.0 * float(np.sum(c[1:])) / max(float(c[0]), 1e-300), int(own.sum())))
        if found:
            value, count = np.array(found).T
            result[joint] = max(1.0, float(np.average(value, weights=count)))
    return result


def spread(logs: WearLogs, e: Array, floor: Array) -> Array:
    """(D,) [N·m] RMS of residuals e (N, D) where they count, at least the floor."""
    return np.maximum(rms(logs, e), np.maximum(floor, LEAST_SIGMA))


def rms(logs: WearLogs, e: Array) -> Array:
    """(D,) [N·m] of residuals e (N, D) where they count."""
    square = np.sum(np.where(logs.used, e, 0.0) ** 2, axis=0) / np.maximum(logs.used.sum(axis=0), 1)
    return np.asarray(np.sqrt(square))
