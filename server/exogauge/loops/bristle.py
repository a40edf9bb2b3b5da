"""The steps of `effects.presliding.bristle`."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from exogauge.loops.compiled import compiled

Array = NDArray[np.float64]

LINEAR = 1e-6  # of n - 1: below, the law is that of n = 1


@compiled("f8[::1], f8, f8[::1]")
def bend(way: Array, n: float, x: Array) -> None:
    """Fills x (T,), from turn to turn. gone: way since the last one."""
    s, u_0, u, gone = 0.0, 1.0, 1.0, 0.0
    exponential = n - 1.0 < LINEAR
    grows = 1.0 if exponential else (n - 1.0) * u_0 ** (n - 1.0)
    for sample in range(1, len(way)):
        step = way[sample] - way[sample - 1]
        if step == 0.0:
            x[sample] = x[sample - 1]
            continue
        towards = 1.0 if step > 0.0 else -1.0
        if towards != s:
            u_0 = 1.0 if s == 0.0 else 2.0 - u
            s, gone = towards, 0.0
            if not exponential:
                grows = (n - 1.0) * u_0 ** (n - 1.0)
        gone += abs(step)
        u = u_0 * (math.exp(-gone) if exponential else math.exp(-math.log1p(grows * gone) / (n - 1.0)))
        x[sample] = s * (1.0 - u)
