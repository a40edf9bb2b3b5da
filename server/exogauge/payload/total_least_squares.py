"""Least squares where the regressor is measured too: LS, TLS, GTLS in one go, and the recursion that tracks them.

Rows [A b] are divided by the standard deviation of b. What tells the methods apart is P, the covariance of a row's
errors, summed over the rows: e_{n+1} e_{n+1}ᵀ per row for LS (only b errs), 1 per row for plain TLS, and the propagated
noise of each row for GTLS.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
import scipy.linalg as sl
from numpy.typing import NDArray

from exogauge.criteria.payload_dynamic import USUAL, Moving
from exogauge.errors import NotIdentifiable
from exogauge.loops.restricted_tls import add_rows, inverse_iteration, track

Array = NDArray[np.float64]

NOT_GENERIC = 1e-8  # of the scaled vector: below, no parameters solve the rows


@final
@dataclass(frozen=True)
class Solution:
    """value: (n,) parameters. mu: mean square of the residuals over what P says of them; 1 where the noise model holds.

    information: (n, n) curvature AᵀA - μ P_A at the solution, the inverse covariance where rows are independent.
    """

    value: Array
    mu: float
    information: Array


def only_output(size: int, rows: int = 1) -> Array:
    """(n+1, n+1) P under which GTLS is LS: `rows` rows whose b errs by one standard deviation. size: n + 1."""
    P = np.zeros((size, size))
    P[-1, -1] = rows
    return P


def triangle(Z: Array) -> Array:
    """(n+1, n+1) upper triangular R with RᵀR = ZᵀZ. Z: (..., n+1)."""
    rows = Z.reshape(-1, Z.shape[-1])
    if len(rows) < rows.shape[1]:
        rows = np.vstack([rows, np.zeros((rows.shape[1] - len(rows), rows.shape[1]))])
    return np.asarray(np.linalg.qr(rows, mode="r"), dtype=np.float64)


def solve(R: Array, P: Array) -> Solution:
    """v = [Φ; -1] of the least vᵀG v / vᵀP v, G = RᵀR. R: (n+1, n+1) `triangle` of [A b]; P: summed covariance.

    Implements [Payload] (26), (28), (33). Differs from print: the division is by -v_{n+1}; the denominator of (33)
    holds P_r. Raises NotIdentifiable where A has no full rank.
    """
    scale = np.linalg.norm(R, axis=0)
    n = len(R) - 1
    if not np.all(scale[:n] > 0) or np.linalg.cond(R[:n, :n] / scale[:n]) > 1e10:
        raise NotIdentifiable("the rows do not decide every parameter")
    scale[n] = scale[n] or 1.0  # nothing but zeros was measured: they are explained as well
    R_s, P_s = R / scale, P / np.outer(scale, scale)
    # [A b] may be exact: then b has no part of its own, and the last entry of R would be divided by.
    R_s[n, n] = np.copysign(max(abs(R_s[n, n]), 1e-14), R_s[n, n] or 1.0)
    half = sl.solve_triangular(R_s, P_s, trans="T")
    ratio = sl.solve_triangular(R_s, half.T, trans="T")
    value, vectors = np.linalg.eigh(0.5 * (ratio + ratio.T))
    v = sl.solve_triangular(R_s, vectors[:, -1]) / scale
    if abs(v[-1] * scale[-1]) < NOT_GENERIC * np.linalg.norm(v * scale):
        raise NotIdentifiable("no parameters solve these rows: the errors stated for the regressor are too large")
    phi = -v[:n] / v[n]
    mu = 1.0 / float(value[-1])
    return Solution(phi, mu, R[:, :n].T @ R[:, :n] - mu * P[:n, :n])


@final
class Recursion:
    """GTLS sample by sample: one step of inverse iteration after each.

    Implements [Payload] (34), (35), in square-root form. Differs from print: P_lᴷ⁻¹ = diag(λ^{k-1}, …, 1), so that old
    rows count least; G⁻¹ P_r v; λ once per sample, not per row. P is summed with the same memory.

    Safeguards: v keeps length one; without a prior `value` is None until 3 rows per parameter; with λ < 1 a sample that
    brings less than half of what forgetting takes leaves everything as it is (`frozen`).
    """

    def __init__(
        self, parameters: int, prior: Array | None = None, *, start: Array | None = None, forget: float = 1.0,
        relative: float = 1e-6, criteria: Moving = USUAL,
    ) -> None:  # fmt: skip
        """prior: (k, n+1) rows [A b] known beforehand, divided by their std. start: (n,) first estimate, default 0.
        forget: λ per sample. relative: size of the first G in units of the first sample's columns, without a prior."""
        self.forget, self._relative, self._rows, self._has_prior = forget, relative, 0, prior is not None
        self._criteria = criteria
        size = parameters + 1
        self.R = np.zeros((size, size)) if prior is None else triangle(prior)
        self.P = only_output(size, 0 if prior is None else len(prior))
        self.v = np.append(np.zeros(parameters) if start is None else start, -1.0)
        self.v /= np.linalg.norm(self.v)
        self.frozen = False

    def update(self, Z: Array, noise: Array) -> None:
        """Z: (r, n+1) rows of one sample. noise: (n+1, n+1) their summed covariance."""
        self._begin(Z)
        self.frozen = (
            self.forget < 1.0 and self._rows > self._criteria.settled_rows * len(self.v) and self._brings_little(Z)
        )
        if not self.frozen:
            add_rows(self.R, self.P, np.array(Z, dtype=np.float64), noise, self.forget)
            inverse_iteration(self.R, self.P, self.v)
            self._rows += len(Z)

    def run(self, Z: Array, noise: Array) -> Array:
        """(T, n) the estimate after each sample, without freezing. Z: (T, r, n+1). noise: (T, n+1, n+1)."""
        self._begin(Z[0])
        out = np.empty((len(Z), Z.shape[2] - 1))
        track(self.R, self.P, self.v, np.array(Z, dtype=np.float64), noise, self.forget, out)
        self._rows += len(Z) * Z.shape[1]
        return out

    def iterate(self, steps: int) -> None:
        """More steps without data: towards the batch solution."""
        for _ in range(steps):
            inverse_iteration(self.R, self.P, self.v)

    @property
    def value(self) -> Array | None:
        """(n,), or None while there is none to be trusted."""
        too_early = not self._has_prior and self._rows < self._criteria.settled_rows * (len(self.v) - 1)
        if too_early or abs(self.v[-1]) < NOT_GENERIC:
            return None
        return np.asarray(-self.v[:-1] / self.v[-1])

    @property
    def mu(self) -> float:
        return float(np.sum((self.R @ self.v) ** 2) / (self.v @ self.P @ self.v))

    def _begin(self, Z: Array) -> None:
        if self._rows == 0:
            size = max(float(np.abs(Z).max()), 1e-300)
            np.fill_diagonal(self.R, np.where(np.diag(self.R) == 0.0, np.sqrt(self._relative) * size, np.diag(self.R)))

    def _brings_little(self, Z: Array) -> bool:
        brought = float(np.sum(sl.solve_triangular(self.R, Z.T, trans="T") ** 2))
        return brought < self._criteria.freeze * (1.0 - self.forget) * len(self.v)
