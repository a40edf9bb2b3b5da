"""The steps of `payload.smoothing`: position, velocity and acceleration from noisy positions, white noise as jerk."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from exogauge.loops.compiled import compiled

Array = NDArray[np.float64]

WARM = 10  # innovations that the start decides, and not the density


@compiled
def forward(z: Array, step: Array, ratio: float, x: Array, P: Array) -> tuple[float, float]:
    """Filter z (T,). step: (T,) time since the sample before, in nominal periods. ratio: jerk density times period⁵
    over the variance of z. Fills x (T, 3) and P (T, 3, 3), in periods and in that variance. Returns Σ ln s and
    Σ ν²/s of the innovations ν, s their variance."""
    logs, squares = 0.0, 0.0
    x[0, 0], x[0, 1], x[0, 2] = z[0], 0.0, 0.0
    P[0] = 0.0
    P[0, 0, 0], P[0, 1, 1], P[0, 2, 2] = 1.0, 1e6, 1e6
    M = np.empty((3, 3))
    for k in range(1, len(z)):
        nu, s = advance(x[k - 1], P[k - 1], z[k], step[k], ratio, M, x[k], P[k])
        if k >= WARM:
            logs += math.log(s)
            squares += nu * nu / s
    return logs, squares


@compiled
def advance(
    x: Array, P: Array, z: float, h: float, ratio: float, M: Array, x_next: Array, P_next: Array
) -> tuple[float, float]:
    """One sample, h periods later: x_next, P_next <- x (3,), P (3, 3) and what z adds. Returns its innovation and the
    innovation's variance. M: (3, 3) for use here."""
    predict(P, h, ratio, M)
    a = x[0] + h * x[1] + 0.5 * h * h * x[2]
    b = x[1] + h * x[2]
    c = x[2]
    s = M[0, 0] + 1.0
    nu = z - a
    x_next[0], x_next[1], x_next[2] = a + M[0, 0] / s * nu, b + M[1, 0] / s * nu, c + M[2, 0] / s * nu
    for i in range(3):
        for j in range(3):
            P_next[i, j] = M[i, j] - M[i, 0] * M[0, j] / s
    return nu, s


@compiled
def predict(P: Array, h: float, ratio: float, M: Array) -> None:
    """M <- F P Fᵀ + Q over h periods."""
    g = 0.5 * h * h
    for j in range(3):
        M[0, j] = P[0, j] + h * P[1, j] + g * P[2, j]
        M[1, j] = P[1, j] + h * P[2, j]
        M[2, j] = P[2, j]
    for i in range(3):
        M[i, 0] = M[i, 0] + h * M[i, 1] + g * M[i, 2]
        M[i, 1] = M[i, 1] + h * M[i, 2]
    M[0, 0] += ratio * h**5 / 20.0
    M[0, 1] += ratio * h**4 / 8.0
    M[0, 2] += ratio * h**3 / 6.0
    M[1, 1] += ratio * h**3 / 3.0
    M[1, 2] += ratio * h**2 / 2.0
    M[2, 2] += ratio * h
    M[1, 0], M[2, 0], M[2, 1] = M[0, 1], M[0, 2], M[1, 2]


@compiled
def gains(step: Array, ratio: float, P: Array, C: Array) -> None:
    """C (T-1, 3, 3) <- the gains of the backward pass, P Fᵀ M⁻¹, with M = L D Lᵀ."""
    M = np.empty((3, 3))
    for k in range(len(step) - 1):
        gain(P[k], step[k + 1], ratio, M, C[k])


@compiled
def gain(P: Array, h: float, ratio: float, M: Array, C: Array) -> None:
    """C (3, 3) <- that of one step of h periods from P. M: (3, 3) for use here."""
    predict(P, h, ratio, M)
    d = M[0, 0]
    l1, l2 = M[1, 0] / d, M[2, 0] / d
    e = M[1, 1] - l1 * M[1, 0]
    l3 = (M[2, 1] - l2 * M[1, 0]) / e
    f = M[2, 2] - l2 * M[2, 0] - l3 * l3 * e
    for i in range(3):
        a = P[i, 0] + h * P[i, 1] + 0.5 * h * h * P[i, 2]
        b = P[i, 1] + h * P[i, 2] - l1 * a
        c = P[i, 2] - l2 * a - l3 * b
        c /= f
        b = b / e - l3 * c
        C[i, 0], C[i, 1], C[i, 2] = a / d - l1 * b - l2 * c, b, c


@compiled
def backward(step: Array, x: Array, C: Array, lag: int, out: Array) -> None:
    """out (T, 3) <- x (T, 3) with what the next `lag` samples add; lag < 0: all of them."""
    size = len(x)
    d = np.empty(3)
    for k in range(size - 1, -1, -1):
        first = size - 1 if lag < 0 else min(k + lag, size - 1)
        if lag < 0 and k < size - 1:
            first = k + 1
            d[:] = out[k + 1]
        else:
            d[:] = x[first]
        for i in range(first - 1, k - 1, -1):
            retreat(x[i], C[i], step[i + 1], d)
        out[k] = d


@compiled
def retreat(x: Array, C: Array, h: float, d: Array) -> None:
    """d (3,) <- x (3,) with what the smoothed state d, h periods later, says of it."""
    d[0] -= x[0] + h * x[1] + 0.5 * h * h * x[2]
    d[1] -= x[1] + h * x[2]
    d[2] -= x[2]
    a = x[0] + C[0, 0] * d[0] + C[0, 1] * d[1] + C[0, 2] * d[2]
    b = x[1] + C[1, 0] * d[0] + C[1, 1] * d[1] + C[1, 2] * d[2]
    c = x[2] + C[2, 0] * d[0] + C[2, 1] * d[1] + C[2, 2] * d[2]
    d[0], d[1], d[2] = a, b, c
