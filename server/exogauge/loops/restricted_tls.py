"""The steps of `payload.total_least_squares.Recursion`."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from exogauge.loops.compiled import compiled

Array = NDArray[np.float64]


@compiled("f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], f8")
def add_rows(R: Array, P: Array, Z: Array, noise: Array, forget: float) -> None:
    """R (n+1, n+1) upper triangular <- root of forget RᵀR + ZᵀZ by Givens rotations; P <- forget P + noise.

    Z: used up."""
    size = R.shape[0]
    root = math.sqrt(forget)
    for i in range(size):
        for j in range(size):
            P[i, j] = forget * P[i, j] + noise[i, j]
            if j >= i:
                R[i, j] *= root
    for row in range(Z.shape[0]):
        for k in range(size):
            z = Z[row, k]
            if z == 0.0:
                continue
            r = R[k, k]
            length = math.sqrt(r * r + z * z)
            c, s = r / length, z / length
            for j in range(k, size):
                a, b = R[k, j], Z[row, j]
                R[k, j] = c * a + s * b
                Z[row, j] = c * b - s * a


@compiled("f8[:,::1], f8[:,::1], f8[::1]")
def inverse_iteration(R: Array, P: Array, v: Array) -> None:
    """v (n+1,) <- (RᵀR)⁻¹ P v, of length one."""
    size = R.shape[0]
    w = np.empty(size)
    for i in range(size):
        total = 0.0
        for j in range(size):
            total += P[i, j] * v[j]
        for j in range(i):
            total -= R[j, i] * w[j]
        w[i] = total / R[i, i]
    square = 0.0
    for i in range(size - 1, -1, -1):
        total = w[i]
        for j in range(i + 1, size):
            total -= R[i, j] * v[j]
        v[i] = total / R[i, i]
        square += v[i] * v[i]
    length = math.sqrt(square)
    for i in range(size):
        v[i] /= length


@compiled("f8[:,::1], f8[:,::1], f8[::1], f8[:,:,::1], f8[:,:,::1], f8, f8[:,::1]")
def track(R: Array, P: Array, v: Array, Z: Array, noise: Array, forget: float, out: Array) -> None:
    """One update per sample: Z (T, r, n+1), used up; noise (T, n+1, n+1); out (T, n) <- the estimate after each."""
    size = R.shape[0]
    for sample in range(Z.shape[0]):
        add_rows(R, P, Z[sample], noise[sample], forget)
        inverse_iteration(R, P, v)
        for i in range(size - 1):
            out[sample, i] = -v[i] / v[size - 1]
