"""What a plot of evidence shows: means over what the effect depends on, in bins of about as many samples each."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Binned(NamedTuple):
    """Each (B,), means over the samples of one bin. spread: of the mean of `before`, one standard deviation."""

    at: Array
    before: Array
    after: Array
    spread: Array
    torque: Array


def binned(at: Array, before: Array, after: Array, torque: Array, turns: bool) -> Binned:
    """All (N,). at: what the effect depends on. before, after: residuals without and with it; torque: what it adds,
    in their unit. turns: it turns round at zero, so that no bin may hold both sides."""
    most, usual, fewest = 40, 12, 8  # bins that an eye follows; samples in each; below, a mean is mostly noise
    bins = int(np.clip(len(at) // usual, 1, most))
    edges = np.unique(np.quantile(at, np.linspace(0.0, 1.0, bins + 1))) if len(at) else np.zeros(1)
    if turns and len(at):
        edges = np.unique([*edges, np.clip(0.0, edges[0], edges[-1])])
    place = np.clip(np.searchsorted(edges, at, side="right") - 1, 0, max(len(edges) - 2, 0))
    count = np.bincount(place, minlength=max(len(edges) - 1, 1))
    full = count >= max(min(fewest, len(at)), 1)

    def mean(of: Array) -> Array:
        return np.asarray(np.bincount(place, of, minlength=len(count))[full] / count[full])

    spread = np.sqrt(np.maximum(mean(before**2) - mean(before) ** 2, 0.0) / count[full])
    return Binned(mean(at), mean(before), mean(after), spread, mean(torque))
