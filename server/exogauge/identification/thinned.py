"""At how few samples a smooth load need be computed: what moves below a cut-off does so between them too."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray


def thinned(samples: int, rate_hz: float, cutoff_hz: float) -> NDArray[np.intp]:
    """Samples at which to compute, rising, the first and the last among them; all where the rate is that low."""
    per_period = 6  # samples in a period of the cut-off frequency, which a cubic spline joins
    stride = max(1, int(rate_hz / (per_period * cutoff_hz)))
    return np.unique(np.append(np.arange(0, samples, stride), samples - 1))


def at_all(samples: int, at: NDArray[np.intp], values: NDArray[np.float64]) -> NDArray[np.float64]:
    """(samples, K) by a cubic spline through values (n, K) at these samples; where they are zero, zero."""
    if len(at) == samples:
        return values
    found, live = np.zeros((values.shape[1], samples)).T, values.any(axis=0)
    found[:, live] = scipy.interpolate.CubicSpline(at, values[:, live])(np.arange(samples))
    return found
