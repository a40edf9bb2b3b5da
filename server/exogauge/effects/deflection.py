"""A link on a spring that may grow stiffer, step by step."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.compiled import compiled

Array = NDArray[np.float64]

COARSEST_S = 1.25e-3  # of a step: a stiff gear rings at 30 Hz
SOLVED = 1e-10  # share of the give that a step's last correction changes
MOST_CORRECTIONS = 20


def deflection(
    load: Array,
    inertia: Array,
    damping: float,
    stiffness: float,
    harder: float,
    power: float,
    slope: Array,
    step: float,
) -> tuple[Array, Array]:
    """r [rad] and r̈ [rad/s²], (T,) each, of J r̈ + d ṙ + k r (1 + c |r|^p) + K r = -load, from rest.

    load [N·m], inertia J [kg·m²], slope K [N·m/rad]: (T,), linear between samples; damping d [N·m·s/rad], stiffness k
    [N·m/rad], harder c [1/rad^p], power p. By the trapezoidal rule, which is stable for every step [s].
    """
    parts = max(1, int(np.ceil(step / COARSEST_S)))
    r, r_ddot = np.empty(len(load)), np.empty(len(load))
    _steps(load, inertia, damping, stiffness, harder, power, slope, step / parts, parts, r, r_ddot)
    return r, r_ddot


@compiled
def _steps(
    load: Array,
    inertia: Array,
    d: float,
    k: float,
    c: float,
    p: float,
    slope: Array,
    h: float,
    parts: int,
    r: Array,
    r_ddot: Array,
) -> None:
    at, v, acc = 0.0, 0.0, 0.0
    for _ in range(MOST_CORRECTIONS):  # where it rests
        more = k * c * abs(at) ** p
        change = (load[0] + (k + slope[0] + more) * at) / (k + slope[0] + (1.0 + p) * more)
        at -= change
        if abs(change) <= SOLVED * abs(at):
            break
    r[0], r_ddot[0] = at, acc
    for n in range(1, len(load)):
        for part in range(1, parts + 1):
            share = part / parts
            J = inertia[n - 1] + share * (inertia[n] - inertia[n - 1])
            K = slope[n - 1] + share * (slope[n] - slope[n - 1])
            pull = load[n - 1] + share * (load[n] - load[n - 1])
            coasting, speed = at + h * v + 0.25 * h * h * acc, v + 0.5 * h * acc
            now = acc
            for _ in range(MOST_CORRECTIONS):
                place = coasting + 0.25 * h * h * now
                rate = speed + 0.5 * h * now
                more = k * c * abs(place) ** p
                left = J * now + d * rate + (k + K + more) * place + pull
                change = left / (J + 0.5 * h * d + 0.25 * h * h * (k + K + (1.0 + p) * more))
                now -= change
                if 0.25 * h * h * abs(change) <= SOLVED * abs(place):
                    break
            acc = now
            at = coasting + 0.25 * h * h * acc
            v = speed + 0.5 * h * acc
        r[n], r_ddot[n] = at, acc
