"""Noise that is stronger at low frequencies: how much of it a channel holds within the band that its far end hides.

Noise whose density falls as that of first-order noise does, x[t] = p x[t-1] + white, has the density

    1 / (1 - 2 p cos ω + p²)   at ω [rad/sample];

p follows from what is seen above two frequencies that lie above all motion, through the filters that show it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from exogauge.criteria.judging import Judging
from exogauge.logs.filtering import LowPass
from exogauge.logs.model import Log
from exogauge.logs.noise import noise_of

Array = NDArray[np.float64]


def hidden_noise(logs: Sequence[Log], names: Sequence[str], cutoff_hz: float, judging: Judging) -> Array:
    """(K,) std of what noise of the channels `names` holds below the cut-off beyond the white noise that their parts
    above twice the cut-off show, over all logs; 0 where the density between two and four times the cut-off is less than
    `noise_falls` times that above, and where no log reaches higher. Where it falls too close to half the sampling
    rate to say how steeply: as much as it may be (`noise_assumed`). Logs that were low-passed before they were stored
    say nothing of it."""
    near, highest, octave = 2.0 * cutoff_hz, 0.35, 2.0
    seen = [log for log in logs if log.stored is None and judging.noise_apart * near <= highest * log.rate_hz]
    if not seen:
        return np.zeros(len(names))
    rate = seen[0].rate_hz
    far = min(octave * near, highest * rate)
    told = far == octave * near and far <= judging.noise_told * rate
    white, beyond = (
        np.mean([[each.std**2 for each in noise_of([log.channels[name] for name in names], log.rate_hz, above)]
                 for log in seen if log.rate_hz == rate], axis=0)
        for above in (near, far)
    )  # fmt: skip
    passes = [LowPass(each, rate) for each in (near, far)]
    assumed = None if told else judging.noise_assumed
    return np.array([_hidden(*each, cutoff_hz, passes, judging, assumed) for each in zip(white, beyond, strict=True)])


def _hidden(
    white: float, beyond: float, cutoff_hz: float, passes: Sequence[LowPass], judging: Judging, assumed: float | None
) -> float:
    """assumed: what a sample hands on, where that is not found."""
    rate, (near, far) = passes[0].rate_hz, (each.cutoff_hz for each in passes)
    frequency = (np.arange(2000) + 0.5) / 4000.0 * rate
    shares = [(1.0 - each.gain(frequency)) ** 2 for each in passes]
    turn = np.cos(2.0 * np.pi * frequency / rate)

    def density(p: float) -> Array:
        return np.asarray(1.0 / (1.0 - 2.0 * p * turn + p * p))

    def ratio(p: float) -> float:
        above, beyond = (float(np.average(density(p), weights=each)) for each in shares)
        return above / beyond

    end = 0.5 * rate
    between = (white * (end - near) - beyond * (end - far)) / (far - near)
    if beyond <= 0.0 or between < judging.noise_falls * beyond:
        return 0.0
    seen, most = white / beyond, judging.noise_steepest
    p = assumed
    if p is None:
        p = most if seen >= ratio(most) else float(brentq(lambda each: ratio(each) - seen, 0.0, most))
    inside = white * np.mean(density(p)[frequency < cutoff_hz]) / np.average(density(p), weights=shares[0])
    return math.sqrt(max(float(inside) - white, 0.0) * cutoff_hz / end)
