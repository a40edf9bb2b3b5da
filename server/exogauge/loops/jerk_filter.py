"""The steps of `payload.smoothing`: position, velocity and acceleration from noisy positions, white noise as jerk.

The filter of `loops.jerk_filter`, sample by sample, and what `lag` samples later say of each: a window of a ring.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from exogauge.loops.compiled import compiled

Array = NDArray[np.float64]

WARM = 10  # innovations that the start decides, and not the density


@compiled("f8[::1], f8[::1], f8, f8[:,::1], f8[:,:,::1]")
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


@compiled()
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


@compiled()
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


@compiled("f8[::1], f8, f8[:,:,::1], f8[:,:,::1]")
def gains(step: Array, ratio: float, P: Array, C: Array) -> None:
    """C (T-1, 3, 3) <- the gains of the backward pass, P Fᵀ M⁻¹, with M = L D Lᵀ."""
    M = np.empty((3, 3))
    for k in range(len(step) - 1):
        gain(P[k], step[k + 1], ratio, M, C[k])


@compiled()
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


@compiled("f8[::1], f8[:,::1], f8[:,:,::1], i8, f8[:,::1]")
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


@compiled()
def retreat(x: Array, C: Array, h: float, d: Array) -> None:
    """d (3,) <- x (3,) with what the smoothed state d, h periods later, says of it."""
    d[0] -= x[0] + h * x[1] + 0.5 * h * h * x[2]
    d[1] -= x[1] + h * x[2]
    d[2] -= x[2]
    a = x[0] + C[0, 0] * d[0] + C[0, 1] * d[1] + C[0, 2] * d[2]
    b = x[1] + C[1, 0] * d[0] + C[1, 1] * d[1] + C[1, 2] * d[2]
    c = x[2] + C[2, 0] * d[0] + C[2, 1] * d[1] + C[2, 2] * d[2]
    d[0], d[1], d[2] = a, b, c


Ints = NDArray[np.int64]

MOVED = 5.0  # standard deviations of an innovation: six joints at 250 Hz reach it by chance every twenty minutes
SHARE = 0.2  # of the newest innovation in their running mean, which sees a slow start within the window
STAYED = 8.0  # standard deviations between two samples of what stands still: by chance once in months
QUIET = 125  # samples in which it did


@compiled(
    "f8[:,::1], f8[::1], i8[::1], f8[:,::1], i8[::1], f8[:,:,::1], f8[:,:,:,::1], f8[:,:,:,::1], f8[:,::1], "
    "f8[::1], i8[::1], f8[::1], f8[::1], f8[:,:,::1], f8[:,::1]",
)
def slide(
    z: Array, h: Array, group: Ints, ratio: Array, place: Ints,
    x: Array, P: Array, C: Array, Z: Array, H: Array, quiet: Ints, anchor: Array, drift: Array,
    out: Array, moving: Array,
) -> int:  # fmt: skip
    """Take samples z (n, K) h (n,) periods after each other; K channels in units of their noise.

    ratio: (K, 2) density of each channel while its group stands still, and while it moves. A group that leaves its
    place is filtered again as one that moves, over the whole window. The ring, of lag + 1 samples: x (N, K, 3),
    P, C (N, K, 3, 3), Z (N, K), H (N,); place: (2,) newest entry and how many there are. quiet: (G,) samples for which
    a group has not moved; anchor: (K,) where it stands; drift: (K,) running mean of its
    innovations, in standard deviations.
    out: (n, K, 3) smoothed states of the samples that are lag back. moving: (n, G) 1: filtered as moving, 0: as still,
    0.5: between the two. Returns how many there are."""
    size, channels, given = len(x), z.shape[1], 0
    M, d = np.empty((3, 3)), np.empty(3)
    for k in range(len(z)):
        if place[1] == 0:
            place[0] = 0
            _begin(z[k], x, P, Z, anchor)
            place[1] = 1
        else:
            old, new = place[0], (place[0] + 1) % size
            place[0], place[1] = new, min(place[1] + 1, size)
            Z[new], H[new] = z[k], h[k]
            for c in range(channels):
                g = group[c]
                r = ratio[c, 0] if quiet[g] >= QUIET else ratio[c, 1]
                gain(P[old, c], h[k], r, M, C[old, c])
                nu, s = advance(x[old, c], P[old, c], z[k, c], h[k], r, M, x[new, c], P[new, c])
                if quiet[g] >= QUIET:
                    drift[c] += SHARE * (nu / math.sqrt(s) - drift[c])
                    if nu * nu > MOVED * MOVED * s or drift[c] * drift[c] > MOVED * MOVED * SHARE / (2.0 - SHARE):
                        quiet[g] = -1
                else:
                    drift[c] = 0.0
                if abs(z[k, c] - anchor[c]) > STAYED:
                    quiet[g] = -1 if quiet[g] >= QUIET else min(quiet[g], 0)
            for g in range(len(quiet)):
                if quiet[g] < 0:
                    _again(g, group, ratio, place, x, P, C, Z, H, M)
                if quiet[g] <= 0:
                    for c in range(channels):
                        if group[c] == g:
                            anchor[c] = z[k, c]
                    quiet[g] = 0
                quiet[g] += 1
        if place[1] == size:
            oldest = (place[0] + 1) % size
            _smoothed(oldest, place[0], group, ratio, x, C, H, quiet, d, out[given], moving[given])
            given += 1
    return given


@compiled("i8[::1], i8[::1], f8[:,::1], f8[:,:,::1], f8[:,:,:,::1], f8[::1], i8[::1], f8[:,:,::1], f8[:,::1]")
def flush(place: Ints, group: Ints, ratio: Array, x: Array, C: Array, H: Array, quiet: Ints, out: Array,
          moving: Array) -> int:  # fmt: skip
    """What is still in the window, by the samples there are; afterwards it is empty. out: (lag, K, 3)."""
    size, d = len(x), np.empty(3)
    left = int(place[1]) - 1 if place[1] == size else int(place[1])  # of a full window the oldest was given
    for k in range(left):
        _smoothed((place[0] - left + 1 + k) % size, place[0], group, ratio, x, C, H, quiet, d, out[k], moving[k])
    place[1] = 0
    return left


@compiled()
def _begin(z: Array, x: Array, P: Array, Z: Array, anchor: Array) -> None:
    """As `forward` begins."""
    for c in range(len(z)):
        x[0, c, 0], x[0, c, 1], x[0, c, 2] = z[c], 0.0, 0.0
        P[0, c] = 0.0
        P[0, c, 0, 0], P[0, c, 1, 1], P[0, c, 2, 2] = 1.0, 1e6, 1e6
        Z[0, c] = z[c]
        anchor[c] = z[c]


@compiled()
def _again(g: int, group: Ints, ratio: Array, place: Ints, x: Array, P: Array, C: Array, Z: Array, H: Array,
           M: Array) -> None:  # fmt: skip
    """The window of a group, as one that moves."""
    size = len(x)
    for k in range(place[1] - 1):
        i = (place[0] - place[1] + 1 + k) % size
        j = (i + 1) % size
        for c in range(x.shape[1]):
            if group[c] == g:
                gain(P[i, c], H[j], ratio[c, 1], M, C[i, c])
                advance(x[i, c], P[i, c], Z[j, c], H[j], ratio[c, 1], M, x[j, c], P[j, c])


@compiled()
def _smoothed(
    first: int, last: int, group: Ints, ratio: Array, x: Array, C: Array, H: Array, quiet: Ints, d: Array,
    out: Array, moving: Array,
) -> None:  # fmt: skip
    size = len(x)
    back = (last - first) % size
    for g in range(len(quiet)):
        moving[g] = 1.0 if quiet[g] < QUIET else 0.5 if quiet[g] < 2 * QUIET else 0.0
    for c in range(x.shape[1]):
        d[:] = x[last, c]
        for k in range(back):
            i = (last - 1 - k) % size
            retreat(x[i, c], C[i, c], H[(i + 1) % size], d)
        out[c, 0], out[c, 1], out[c, 2] = d[0], d[1], d[2]
