"""Weighted least squares with a prior, in square-root form, from sufficient statistics.

Least squares from normal equations, within bounds.
"""

from __future__ import annotations

from functools import cached_property
from typing import final

import numpy as np
import scipy.linalg as sl
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from exogauge.estimation.prior import Prior
from exogauge.estimation.statistics import SquareRoot

Array = NDArray[np.float64]

CORRECTIONS = 6  # of a solution of the normal equations; two are usual
CORRECTED = 1e-14  # relative: a correction that is as small as rounding


@final
class PriorLeastSquares:
    """min Σ w (A x - y)² + strength · ‖s - s_ref‖²_W over all s with x = D s.

    Solved in x: the prior on s is, for what the data see, a prior on x with covariance D W^{-1} D^T, and the rest of s
    follows (`Prior.lift`). So parameters that the data cannot see are held by construction, not by a small weight.

    information (m, F), target (m,): the data alone, ‖information x_free - target‖², rows divided by their std.

    Implements [Evaluator] (15). Differs from print: W_phi has the size of the parameters
    wanted, W_xi that of all joint parameters (5 N_J, more with more effects).
    """

    def __init__(self, data: SquareRoot, prior: Prior, strength: float) -> None:
        free, known = prior.free, np.setdiff1d(np.arange(data.R.shape[1]), prior.free)
        self.prior, self.strength = prior, strength
        self.information = data.R[:, free]
        self.target = data.z - data.R[:, known] @ prior.seen_mean[known]
        self._believed, curvature = prior.root(strength), data.gram[np.ix_(free, free)] + prior.information(strength)
        self._scale = np.sqrt(np.diag(curvature))
        self.x = prior.seen_mean.copy()
        self.x[free] += self._step(curvature, self.target - self.information @ prior.seen_mean[free])

    def _step(self, curvature: Array, offset: Array) -> Array:
        """(F,) from the mean to the solution: by the normal equations, corrected by what they leave unanswered, at a
        third of the factorisation's work and to its digits; by that where corrections do not settle."""
        A, U, size = self.information, self._believed, self._scale
        factor, failed = sl.lapack.dpotrf(curvature / np.outer(size, size), overwrite_a=1)
        step, last = np.zeros(len(size)), np.inf
        for _ in range(0 if failed else CORRECTIONS):
            left = (offset - A @ step) @ A - (U @ step) @ U
            more = sl.lapack.dpotrs(factor, left / size)[0] / size
            step, moved = step + more, float(np.linalg.norm(size * more))
            if moved <= CORRECTED * float(np.linalg.norm(size * step)):
                return np.asarray(step)
            if moved > 0.1 * last:
                break
            last = moved
        return np.asarray(sl.solve_triangular(self._root, self._factor(offset)[:, -1]))

    @cached_property
    def _root(self) -> Array:
        """(F, F) upper triangular, R^T R the curvature."""
        return np.asarray(np.triu(self._factor(np.zeros(len(self.information)))[:, :-1]) * self._scale)

    def _factor(self, offset: Array) -> Array:
        """(F, F + 1) of data and prior stacked, columns scaled, and what it makes of the data's right-hand side.

        What the data say stands above a weak belief: the other way round, the belief would lose its digits.
        """
        rows, size = len(offset), len(self._scale)
        stacked = np.zeros((rows + size, size + 1), order="F")
        stacked[:rows, :size], stacked[:rows, size] = self.information / self._scale, offset
        stacked[rows:, :size] = self._believed / self._scale
        factor, *_ = sl.lapack.dgeqrf(stacked, lwork=64 * (size + 1), overwrite_a=1)
        return np.asarray(factor[:size])

    def shift(self, step: Array) -> None:
        """Move the solution, and the data that it answers to, by step: (P,), to take off a known bias.

        Parameters known exactly stay.
        """
        free = self.prior.free
        self.x[free] += step[free]
        self.target = self.target + self.information @ step[free]

    def covariance(self, meat: Array | None = None) -> Array:
        """(P, P) covariance of x about the truth.

        meat: (P, P) covariance of the weighted score Σ w A^T e, from coloured residuals; without it the residuals are
        taken as white with the variances that the weights state. The prior's own error enters with its stated
        covariance, whatever strength it was given: H^{-1} (meat + strength² P^{-1}) H^{-1}.
        """
        free = self.prior.free
        inner = self.information.T @ self.information if meat is None else meat[np.ix_(free, free)]
        inner = inner + self.prior.information(self.strength**2)
        half = sl.solve_triangular(self._root, sl.solve_triangular(self._root, inner, trans="T").T, trans="T")
        full = np.zeros((len(self.x), len(self.x)))
        outer = sl.solve_triangular(self._root, sl.solve_triangular(self._root, half).T)
        full[np.ix_(free, free)] = 0.5 * (outer + outer.T)
        return full

    def divided(self, columns: Array) -> Array:
        """(P, m) H^{-1} columns, H the curvature of data and prior together. columns: (P, m)."""
        free = self.prior.free
        out = np.zeros_like(columns)
        out[free] = sl.solve_triangular(self._root, sl.solve_triangular(self._root, columns[free], trans="T"))
        return out

    def condition_and_rank(self) -> tuple[float, int]:
        """Condition number and rank of the column-scaled information of the data alone."""
        norms = np.linalg.norm(self.information, axis=0)
        live = norms > 1e-9 * norms.max()
        singular = np.linalg.svd(self.information[:, live] / norms[live], compute_uv=False)
        rank = int((singular > 1e-8 * singular[0]).sum())
        return float(singular[0] / singular[rank - 1]), rank


def bounded_least_squares(H: Array, g: Array, low: Array, high: Array) -> Array:
    """(C,) argmin ½ xᵀ H x - gᵀ x with low ≤ x ≤ high. H: (C, C) positive definite."""
    x = np.linalg.solve(H, g)
    if np.all(x >= low) and np.all(x <= high):
        return np.asarray(x)
    if len(x) == 1:
        return np.clip(x, low, high)
    L = np.linalg.cholesky(H)
    found = lsq_linear(L.T, np.linalg.solve(L, g), bounds=(low, high), method="bvls")
    return np.asarray(np.clip(found.x, low, high))
