"""A link on a spring that may grow stiffer, step by step."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

COARSEST_S = 1.25e-3  # of a step: a stiff gear rings at 30 Hz


def deflection(
    load: Array,
    inertia: Array,
    damping: Array,
    stiffness: Array,
    harder: Array,
    power: Array,
    slope: Array,
    step: float,
) -> tuple[Array, Array]:
    """r [rad] and r̈ [rad/s²], (T, L) each, of J r̈ + d ṙ + k r (1 + c |r|^p) + K r = -load, from rest.

    load [N·m], inertia J [kg·m²]: (T,); slope K [N·m/rad]: (T, L); all linear between samples. Damping d [N·m·s/rad],
    stiffness k [N·m/rad], harder c [1/rad^p], power p: (L,), of springs that know nothing of each other, side by side.
    By the trapezoidal rule, which is stable for every step [s].
    """
    from exogauge.loops.deflection import bend

    parts = max(1, int(np.ceil(step / COARSEST_S)))
    r, r_ddot = np.empty(slope.shape), np.empty(slope.shape)
    bend(load, inertia, damping, stiffness, harder, power, slope, step / parts, parts, r, r_ddot)
    return r, r_ddot
