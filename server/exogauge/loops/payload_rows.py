"""Rows of [Payload] (5) with the covariance of their errors, and what the errors leave of a compensated wrench."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.loops.compiled import compiled

Array = NDArray[np.float64]

COLUMN = np.array([[4, 5, 7], [5, 6, 8], [7, 8, 9]])  # of the inertia's entry (i, m)


@compiled("f8[:,::1], f8[:,::1], f8[:,::1], f8[:,:,::1], f8[:,::1], f8[::1], f8, f8[:,:,::1], f8[:,:,::1]")
def fill(
    b: Array, alpha: Array, omega: Array, noise: Array, wrench: Array, std: Array, sign: float, Z: Array, N: Array
) -> None:
    """Z (T, 6, 17) <- [s A, 1, F] divided by std (6,). N (T, 17, 17) <- covariance of a sample's errors, summed over
    its six rows. b = a - g, alpha, omega: (T, 3). noise: (T, 9, K) root of their covariance. wrench: (T, 6)."""
    D, C, B = np.zeros((6, 9, 10)), np.empty((9, 9)), np.empty((9, 10))
    Z[:] = 0.0
    N[:] = 0.0
    for t in range(len(b)):
        _regressor(b[t], alpha[t], omega[t], Z[t], D)
        _square(noise[t], C)
        for i in range(6):
            first, last = (0, 4) if i < 3 else (1, 10)
            weight = 1.0 / (std[i] * std[i])
            for k in range(9):
                for p in range(first, last):
                    total = 0.0
                    for m in range(9):
                        total += C[k, m] * D[i, m, p]
                    B[k, p] = total * weight
            for p in range(first, last):
                for m in range(9):
                    slope = D[i, m, p]
                    if slope != 0.0:
                        for r in range(first, last):
                            N[t, p, r] += slope * B[m, r]
            for p in range(10):
                Z[t, i, p] *= sign / std[i]
            Z[t, i, 10 + i], Z[t, i, 16] = 1.0 / std[i], wrench[t, i] / std[i]
        N[t, 16, 16] = 6.0


@compiled(
    "f8[:,::1], f8[:,::1], f8[:,::1], f8[:,:,::1], f8[:,::1], f8[::1], f8[:,::1], f8[::1], f8, f8[:,::1], f8[:,:,::1]",
)
def spread(
    b: Array, alpha: Array, omega: Array, noise: Array, wrench: Array, x: Array, covariance: Array, std: Array,
    sign: float, left: Array, out: Array,
) -> None:  # fmt: skip
    """left (T, 6) <- F - F_0 - s A Φ of F (T, 6); out (T, 6, 6) <- its covariance by the sensor's noise, that of the
    kinematics and of x (16,)."""
    D, C, A, G = np.zeros((6, 9, 10)), np.empty((9, 9)), np.zeros((6, 17)), np.empty((6, 16))
    slope, by = np.empty((6, 9)), np.empty((6, 9))
    for t in range(len(b)):
        A[:] = 0.0
        _regressor(b[t], alpha[t], omega[t], A, D)
        _square(noise[t], C)
        for i in range(6):
            left[t, i] = wrench[t, i] - x[10 + i]
            for p in range(10):
                left[t, i] -= sign * A[i, p] * x[p]
            A[i, 10 + i] = sign  # s (A, s 1): the sign goes out of the square
            for m in range(9):
                total = 0.0
                for p in range(10):
                    total += D[i, m, p] * x[p]
                slope[i, m] = total
            for p in range(16):
                total = 0.0
                for r in range(16):
                    total += A[i, r] * covariance[r, p]
                G[i, p] = total
            for m in range(9):
                total = 0.0
                for k in range(9):
                    total += slope[i, k] * C[k, m]
                by[i, m] = total
        for i in range(6):
            for k in range(6):
                total = 0.0
                for p in range(16):
                    total += G[i, p] * A[k, p]
                for m in range(9):
                    total += by[i, m] * slope[k, m]
                out[t, i, k] = total
            out[t, i, i] += std[i] * std[i]


@compiled()
def _regressor(b: Array, alpha: Array, omega: Array, A: Array, D: Array) -> None:
    """Adds A of [Payload] (5) for s = +1 to the first ten columns; D (6, 9, 10) <- its slopes by [a - g, α, ω]."""
    D[:] = 0.0
    square = omega[0] * omega[0] + omega[1] * omega[1] + omega[2] * omega[2]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        A[i, 0] += b[i]
        D[i, i, 0] = 1.0
        A[i, 1 + j] -= alpha[k]
        A[i, 1 + k] += alpha[j]
        D[i, 3 + k, 1 + j], D[i, 3 + j, 1 + k] = -1.0, 1.0
        A[3 + i, 1 + j] += b[k]
        A[3 + i, 1 + k] -= b[j]
        D[3 + i, k, 1 + j], D[3 + i, j, 1 + k] = 1.0, -1.0
        A[i, 1 + i] -= square
        for m in range(3):
            A[i, 1 + m] += omega[i] * omega[m]
            D[i, 6 + m, 1 + m] += omega[i]
            D[i, 6 + i, 1 + m] += omega[m]
            D[i, 6 + m, 1 + i] -= 2.0 * omega[m]
            c = COLUMN[i, m]
            A[3 + i, c] += alpha[m]
            D[3 + i, 3 + m, c] += 1.0
            c = COLUMN[k, m]  # ω x L(ω): ω_j L_k - ω_k L_j
            A[3 + i, c] += omega[j] * omega[m]
            D[3 + i, 6 + j, c] += omega[m]
            D[3 + i, 6 + m, c] += omega[j]
            c = COLUMN[j, m]
            A[3 + i, c] -= omega[k] * omega[m]
            D[3 + i, 6 + k, c] -= omega[m]
            D[3 + i, 6 + m, c] -= omega[k]


@compiled()
def _square(root: Array, C: Array) -> None:
    """C (9, 9) <- root rootᵀ."""
    for k in range(9):
        for m in range(k + 1):
            total = 0.0
            for r in range(root.shape[1]):
                total += root[k, r] * root[m, r]
            C[k, m], C[m, k] = total, total
