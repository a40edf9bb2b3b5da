"""Noise that is stronger at low frequencies: how much of it a channel holds within the band that its far end hides.

Noise whose density falls as that of first-order noise does, x[t] = p x[t-1] + white, has the mean density

    M(p; a, b) = 2 / ((1 - p²) (b - a)) [atan(r tan(ω/2))]  from ω = a to b,   r = (1 + p) / (1 - p)

between two frequencies [rad/sample]; p follows from what is seen in two stretches above all motion.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from exogauge.criteria.judging import Judging
from exogauge.logs.model import Log
from exogauge.logs.noise import noise_of

Array = NDArray[np.float64]


def hidden_noise(logs: Sequence[Log], names: Sequence[str], cutoff_hz: float, judging: Judging) -> Array:
    """(K,) std of what noise of the channels `names` holds below the cut-off beyond the white noise that their parts
    above twice the cut-off show, over all logs; 0 where the density between two and four times the cut-off is less than
    `noise_falls` times that above, and where no log reaches higher. Logs that were low-passed before they were
    stored say nothing of it."""
    near, far = 2.0 * cutoff_hz, 4.0 * cutoff_hz
    seen = [log for log in logs if log.stored is None and far <= 0.35 * log.rate_hz]
    if not seen:
        return np.zeros(len(names))
    rate = seen[0].rate_hz
    white, beyond = (
        np.mean([[each.std**2 for each in noise_of([log.channels[name] for name in names], log.rate_hz, above)]
                 for log in seen if log.rate_hz == rate], axis=0)
        for above in (near, far)
    )  # fmt: skip
    ends = [2.0 * math.pi * each / rate for each in (cutoff_hz, near, far)]
    return np.array([_hidden(*each, ends, judging) for each in zip(white, beyond, strict=True)])


def _hidden(white: float, beyond: float, ends: Sequence[float], judging: Judging) -> float:
    cutoff, near, far = ends

    def ratio(p: float) -> float:
        return _density(p, near, math.pi) / _density(p, far, math.pi)

    between = (white * (math.pi - near) - beyond * (math.pi - far)) / (far - near)
    if beyond <= 0.0 or between < judging.noise_falls * beyond:
        return 0.0
    seen = white / beyond
    most = judging.noise_steepest
    p = most if seen >= ratio(most) else float(brentq(lambda each: ratio(each) - seen, 0.0, most))
    inside = white * _density(p, 0.0, cutoff) / _density(p, near, math.pi)
    return math.sqrt(max(inside - white, 0.0) * cutoff / math.pi)


def _density(p: float, low: float, high: float) -> float:
    """Mean over frequencies [rad/sample], of white noise of variance one that was fed back."""
    r = (1.0 + p) / (1.0 - p)

    def integral(omega: float) -> float:
        return math.pi / 2.0 if omega >= math.pi else math.atan(r * math.tan(omega / 2.0))

    return 2.0 * (integral(high) - integral(low)) / ((1.0 - p * p) * (high - low))
