"""The fits of `plausibility.axis_fit`: few columns of one axis, most of which never explain with a negative sign."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.loops.compiled import compiled

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


@compiled("f8[:,:,::1], f8[:,::1], f8[::1], f8[:,::1]")
def explain(M: Array, b: Array, most: Array, best: Array) -> None:
    """M: (G, K, K) products of columns, b: (G, K) with what they explain. most: (G,), best: (G, K) coefficients, of
    which all but the last are at least 0."""
    K = b.shape[1]
    R, x, chosen = np.empty((K, K)), np.empty(K), np.empty(K, dtype=np.int64)
    for g in range(len(b)):
        most[g] = _explain(M[g], b[g], R, x, chosen, best[g])


@compiled("f8[:,::1], f8[::1], f8[::1], f8[::1], f8[::1], b1, f8[::1], f8, f8[::1], i8[::1], f8[:,::1]")
def scan(
    Z: Array, load: Array, doubt: Array, effort: Array, gains: Array, other_bodies: bool, shares: Array, offset: float,
    found: Array, which: Ints, best: Array,
) -> None:  # fmt: skip
    """Log likelihood of effort (N,) = g load (N,) + Z (N, K) x + noise, by factor g of `gains` (G,).

    doubt: (N,) variance of the load. shares: (S,) std of the noise. offset: what is added to the last column's square.
    other_bodies: the load once, its doubt g times. found: (G,), which: (G,) the share, best: (G, K) x of the likeliest.
    """
    N, K = Z.shape
    M, b, x = np.empty((K, K)), np.empty(K), np.empty(K)
    R, y, chosen = np.empty((K, K)), np.empty(K), np.empty(K, dtype=np.int64)
    for g in range(len(gains)):
        found[g] = -np.inf
        scale, times = gains[g] ** 2, 1.0 if other_bodies else gains[g]
        for s in range(len(shares)):
            M[:], b[:] = 0.0, 0.0
            whole, sizes, square = 0.0, 0.0, shares[s] ** 2
            for n in range(N):
                w = 1.0 / (scale * doubt[n] + square)
                r = effort[n] - times * load[n]
                whole += w * r * r
                sizes += np.log(w)
                for k in range(K):
                    wz = w * Z[n, k]
                    b[k] += wz * r
                    for l in range(k + 1):  # noqa: E741
                        M[k, l] += wz * Z[n, l]
            for k in range(K):
                for l in range(k):  # noqa: E741
                    M[l, k] = M[k, l]
            M[K - 1, K - 1] += offset
            likely = 0.5 * (_explain(M, b, R, y, chosen, x) - whole + sizes)
            if likely > found[g]:
                found[g], which[g] = likely, s
                best[g] = x


@compiled()
def _explain(M: Array, b: Array, R: Array, x: Array, chosen: Ints, best: Array) -> float:
    """Of one: the most, by every choice of columns beside the last. R, x, chosen: (K, K), (K,), (K,) to work in."""
    K, most = len(b), -np.inf
    best[:] = 0.0
    for choice in range(1 << (K - 1)):
        count = 0
        for k in range(K):
            if k == K - 1 or (choice >> k) & 1:
                chosen[count] = k
                count += 1
        if not _solve(M, b, R, x, chosen, count):
            continue
        gained, fits = 0.0, True
        for i in range(count):
            gained += x[i] * b[chosen[i]]
            fits = fits and (i == count - 1 or x[i] >= 0.0)
        if fits and gained > most:
            most = gained
            best[:] = 0.0
            for i in range(count):
                best[chosen[i]] = x[i]
    return most


@compiled()
def _solve(M: Array, b: Array, R: Array, x: Array, chosen: Ints, count: int) -> bool:
    """x: of the chosen columns, by Cholesky; False where they are not independent."""
    least = 1e-12  # on the diagonal: a column that is 0 throughout explains nothing
    for i in range(count):
        for j in range(i + 1):
            value = M[chosen[i], chosen[j]] + (least if i == j else 0.0)
            for k in range(j):
                value -= R[i, k] * R[j, k]
            if i == j:
                if not value > 0.0:
                    return False
                R[i, i] = np.sqrt(value)
            else:
                R[i, j] = value / R[j, j]
    for i in range(count):
        value = b[chosen[i]]
        for k in range(i):
            value -= R[i, k] * x[k]
        x[i] = value / R[i, i]
    for back in range(count):
        i = count - 1 - back
        value = x[i]
        for k in range(i + 1, count):
            value -= R[k, i] * x[k]
        x[i] = value / R[i, i]
    return True
