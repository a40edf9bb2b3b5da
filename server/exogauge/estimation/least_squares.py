"""Weighted least squares with a prior, in square-root form, from sufficient statistics.

Least squares from normal equations, within bounds.
"""

from __future__ import annotations

from typing import final

import numpy as np
import scipy
import scipy.linalg as sl
from numpy.typing import NDArray

from exogauge.estimation.prior import Prior
from exogauge.estimation.statistics import SquareRoot

Array = NDArray[np.float64]


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
        offset = self.target - self.information @ prior.seen_mean[free]
        believed, size = prior.root(strength), len(free)
        scale = np.sqrt(np.sum(self.information**2, axis=0) + np.sum(believed**2, axis=0))
        # What the data say stands above a weak belief: the other way round, the belief would lose its digits.
        stacked = np.zeros((len(offset) + size, size + 1), order="F")
        stacked[: len(offset), :size], stacked[: len(offset), size] = self.information / scale, offset
        stacked[len(offset) :, :size] = believed / scale
        factor, *_ = sl.lapack.dgeqrf(stacked, lwork=64 * (size + 1), overwrite_a=1)
        self._root = np.triu(factor[:size, :size]) * scale
        step = sl.solve_triangular(self._root, factor[:size, size])
        self.x = prior.seen_mean.copy()
        self.x[free] += step

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
    if len(g) == 1:
        return np.asarray(np.clip(g / H[0], low, high))
    x = np.linalg.solve(H, g)
    if np.all(x >= low) and np.all(x <= high):
        return np.asarray(x)
    L = np.linalg.cholesky(H)
    found = scipy.optimize.lsq_linear(L.T, np.linalg.solve(L, g), bounds=(low, high), method="bvls")
    return np.asarray(np.clip(found.x, low, high))
