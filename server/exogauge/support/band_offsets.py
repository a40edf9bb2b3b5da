"""A constant torque that a joint has in one log and not in the next: unknown, near zero, and no band's.

    e = A θ + o + n,    o ~ N(0, s²),    γ = W / (W + s⁻²),    W = Σ w

over the samples of one log and joint, whose weights are w. With o integrated out, the information is
Aᵀ w A - γ W m mᵀ, m the weighted mean of A's rows; the score is Aᵀ w (e - γ mean(e)). With s = 0 nothing is changed.
The same as a column of ones per log and joint, each believed to be 0 ± s.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.support.band_rows import WearLogs

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Offsets:
    """Of each log and joint. weight: (N, D) [1/(N·m)²]. X, below: errors (N, D) or slopes (N, D, P)."""

    logs: WearLogs
    weight: Array

    @cached_property
    def total(self) -> Array:
        """(L, D) W"""
        return self._by_log(self.weight)

    @cached_property
    def shares(self) -> Array:
        """(L, D) γ: how much of a mean error is taken for an offset."""
        told = self.total * self.logs.zero_std**2
        return np.asarray(told / (1.0 + told))

    @cached_property
    def doubted(self) -> bool:
        return bool(self.logs.zero_std.any())

    def likeliest(self, e: Array) -> Array:
        """(L, D) [N·m] γ mean(e)."""
        return self.shares * self._means(e)

    def without(self, X: Array) -> Array:
        """(N, D, …) X - γ mean(X): what of errors or slopes is left beside offsets."""
        return self._less(X, self.shares) if self.doubted else X

    def whitened(self, X: Array) -> Array:
        """(N, D, …) X - c mean(X), c = 1 - √(1 - γ): its weighted squares are the information that offsets leave."""
        return self._less(X, self.shares / (1.0 + np.sqrt(1.0 - self.shares))) if self.doubted else X

    def beside(self, e: Array) -> tuple[Array, float]:
        """(N, D) what of errors is left beside the likeliest offsets, and what these cost: Σ (o / s)²."""
        if not self.doubted:
            return e, 0.0
        found, std = self.likeliest(e), self.logs.zero_std
        cost = np.sum(np.divide(found, std, out=np.zeros_like(std), where=std > 0.0) ** 2)
        return self._less_in_each(e, found), float(cost)

    def score(self, told: Array) -> Array:
        """(P, P) of the score, from offsets of the declared size. told: (N, D, P) w (A - γ mean(A))."""
        moved = (self._by_log(told) * self.logs.zero_std[:, :, None]).reshape(-1, told.shape[2])
        return np.asarray(moved.T @ moved)

    def _less(self, X: Array, share: Array) -> Array:
        return self._less_in_each(X, _beside(share, X) * self._means(X))

    def _means(self, X: Array) -> Array:
        """(L, D, …)"""
        total = _beside(self.total, X)
        return np.asarray(self._by_log(_beside(self.weight, X) * X) / np.where(total > 0.0, total, 1.0))

    def _by_log(self, X: Array) -> Array:
        """(L, D, …) sums."""
        return np.stack([X[span].sum(axis=0) for span in self.logs.spans])

    def _less_in_each(self, X: Array, values: Array) -> Array:
        """X less what is each log's own, (L, D, …)."""
        out = np.empty_like(X)
        for span, own in zip(self.logs.spans, values, strict=True):
            np.subtract(X[span], own, out=out[span])
        return out


def _beside(values: Array, X: Array) -> Array:
    """Values (., D) with as many axes as X."""
    return values.reshape(*values.shape, *(1,) * (X.ndim - 2))
