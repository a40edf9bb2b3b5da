"""The steps of `effects.deflection`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.loops.compiled import compiled

Array = NDArray[np.float64]

SOLVED = 1e-10  # share of the give that a step's last correction changes
MOST_CORRECTIONS = 20


@compiled(
    "f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[:,::1], f8, i8, f8[:,::1], f8[:,::1]",
    "f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[:,:], f8, i8, f8[:,::1], f8[:,::1]",
    "f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[:], f8[:,::1], f8, i8, f8[:,::1], f8[:,::1]",
    "f8[::1], f8[:], f8[::1], f8[::1], f8[::1], f8[::1], f8[:,::1], f8, i8, f8[:,::1], f8[:,::1]",
    "f8[::1], f8[:], f8[::1], f8[::1], f8[::1], f8[:], f8[:,::1], f8, i8, f8[:,::1], f8[:,::1]",
)
def bend(
    load: Array,
    inertia: Array,
    d: Array,
    k: Array,
    c: Array,
    p: Array,
    slope: Array,
    h: float,
    parts: int,
    r: Array,
    r_ddot: Array,
) -> None:
    """Fills r and r_ddot (T, L). d: damping; k, c, p: stiffness and how it grows; h: of a step, `parts` of
    them a sample.

    Springs are the inner loop: the processor works on one while it waits for another.
    """
    length, springs = slope.shape
    at, v, acc = np.zeros(springs), np.zeros(springs), np.zeros(springs)
    for b in range(springs):
        for _ in range(MOST_CORRECTIONS):  # where it rests
            more = k[b] * c[b] * abs(at[b]) ** p[b] if c[b] != 0.0 else 0.0
            change = (load[0] + (k[b] + slope[0, b] + more) * at[b]) / (k[b] + slope[0, b] + (1.0 + p[b]) * more)
            at[b] -= change
            if abs(change) <= SOLVED * abs(at[b]):
                break
        r[0, b], r_ddot[0, b] = at[b], acc[b]
    for n in range(1, length):
        for part in range(1, parts + 1):
            share = part / parts
            J = inertia[n - 1] + share * (inertia[n] - inertia[n - 1])
            pull = load[n - 1] + share * (load[n] - load[n - 1])
            for b in range(springs):
                K = slope[n - 1, b] + share * (slope[n, b] - slope[n - 1, b])
                coasting, speed = at[b] + h * v[b] + 0.25 * h * h * acc[b], v[b] + 0.5 * h * acc[b]
                now = acc[b]
                for _ in range(MOST_CORRECTIONS):
                    place = coasting + 0.25 * h * h * now
                    rate = speed + 0.5 * h * now
                    more = k[b] * c[b] * abs(place) ** p[b] if c[b] != 0.0 else 0.0
                    left = J * now + d[b] * rate + (k[b] + K + more) * place + pull
                    change = left / (J + 0.5 * h * d[b] + 0.25 * h * h * (k[b] + K + (1.0 + p[b]) * more))
                    now -= change
                    straight = c[b] == 0.0  # then the first correction is exact
                    if straight or 0.25 * h * h * abs(change) <= SOLVED * abs(place):
                        break
                acc[b] = now
                at[b] = coasting + 0.25 * h * h * now
                v[b] = speed + 0.5 * h * now
        for b in range(springs):
            r[n, b], r_ddot[n, b] = at[b], acc[b]
