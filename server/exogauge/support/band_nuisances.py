"""What adds to a joint's torque and is no band's: unknown, near zero, and taken into account in every fit of bands.

    e = A θ + o + V v + n,    o ~ N(0, s²),    v ~ N(0, 1)

o is a constant of one log and joint, γ = W / (W + s⁻²), W = Σ w over its samples, whose weights are w; v are further
unknowns, such as where a via point is, each of which adds its column of V. With both integrated out the score is
Aᵀ w e⊥, the information Aᵀ w A⊥:

    x⊥ = y - γ mean(y),    y = x - V v(x),    v(x) = (1 + Vᵀ w V°)⁻¹ V°ᵀ w x,    V° = V - γ mean(V)

The same as columns of ones and V beside A, each unknown believed to be 0 ± its standard deviation.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np
import scipy
from numpy.typing import NDArray

from exogauge.support.band_rows import WearLogs

Array = NDArray[np.float64]
IntArray = NDArray[np.intp]


@final
@dataclass(frozen=True)
class Between:
    """(N, D, m) columns that are told at n samples, along straight lines between these. values: (n, D, m); shares:
    (n, N) of each sample."""

    values: Array
    shares: scipy.sparse.csr_array

    def times(self, v: Array) -> Array:
        """(N, D, …) of (m, …)."""
        n, D, _ = self.values.shape
        return np.asarray(self._of_each @ (self.values @ v).reshape(n, -1)).reshape(-1, D, *v.shape[1:])

    def against(self, X: Array) -> Array:
        """(m, …) sums over samples and joints of (N, D, …)."""
        n, D, _ = self.values.shape
        own = np.asarray(self.shares @ X.reshape(len(X), -1)).reshape(n * D, *X.shape[2:])
        return np.asarray(self._flat.T @ own)

    def at(self, chosen: IntArray) -> Between:
        """The same for some of the N."""
        return Between(self.values, self.shares[:, chosen])

    @cached_property
    def _flat(self) -> Array:
        """(n D, m): multiplied at once, not sample by sample."""
        return self.values.reshape(-1, self.values.shape[2])

    @cached_property
    def _of_each(self) -> scipy.sparse.csr_array:
        """(N, n) shares turned around: a search asks for them thousands of times."""
        return self.shares.T.tocsr()


@final
@dataclass(frozen=True)
class Nuisances:
    """weight: (N, D) [1/(N·m)²]. added: (N, D, m) [N·m] V, per standard deviation of each further unknown; None: there
    are none. X, below: errors (N, D) or slopes (N, D, P)."""

    logs: WearLogs
    weight: Array
    added: Between | None = None

    @cached_property
    def total(self) -> Array:
        """(L, D) W"""
        return self._by_log(self.weight)

    @cached_property
    def _root(self) -> Array:
        """(N, D) √w"""
        return np.sqrt(self.weight)

    @cached_property
    def shares(self) -> Array:
        """(L, D) γ: how much of a mean error is taken for an offset."""
        told = self.total * self.logs.zero_std**2
        return np.asarray(told / (1.0 + told))

    @cached_property
    def doubted(self) -> bool:
        return bool(self.logs.zero_std.any())

    def likeliest_offsets(self, e: Array) -> Array:
        """(L, D) [N·m] γ mean(e)."""
        return self.shares * self._means(e)

    def without(self, X: Array) -> Array:
        """(N, D, …) X⊥: what of errors or slopes is left beside all of this."""
        return self._beside_offsets(self._beside_added(X)[0])

    def whitened(self, X: Array) -> Array:
        """(N, D, …) X - c mean(X), c = 1 - √(1 - γ): its weighted squares are the information that offsets leave."""
        return self._less(X, self.shares / (1.0 + np.sqrt(1.0 - self.shares))) if self.doubted else X

    def information(self, A: Array) -> Array:
        """(P, P) Aᵀ w A⊥, as a sum of squares."""
        left, v = self._beside_added(A)
        flat = (self.whitened(left) * self._root[:, :, None]).reshape(-1, A.shape[2])
        return np.asarray(flat.T @ flat + v.T @ v)

    def beside(self, e: Array) -> tuple[Array, float]:
        """(N, D) what of errors is left beside the likeliest of all of this, and what it costs: Σ (o / s)² + Σ v²."""
        e, v = self._beside_added(e)
        cost = float(v @ v)
        if not self.doubted:
            return e, cost
        found, std = self.likeliest_offsets(e), self.logs.zero_std
        cost += float(np.sum(np.divide(found, std, out=np.zeros_like(std), where=std > 0.0) ** 2))
        return self._less_in_each(e, found), cost

    def score_of_offsets(self, told: Array) -> Array:
        """(P, P) of the score, from offsets of the declared size. told: (N, D, P) w A⊥."""
        moved = (self._by_log(told) * self.logs.zero_std[:, :, None]).reshape(-1, told.shape[2])
        return np.asarray(moved.T @ moved)

    def _beside_offsets(self, X: Array) -> Array:
        return self._less(X, self.shares) if self.doubted else X

    def _beside_added(self, X: Array) -> tuple[Array, Array]:
        """(N, D, …) X - V v(X), and (m, …) v(X)."""
        if self.added is None:
            return X, np.zeros((0, *X.shape[2:]))
        told = self.added.against(_beside(self.weight, X) * self._beside_offsets(X))  # V°ᵀ w X = Vᵀ w X°
        v = self._doubt_of_added @ told
        return X - self.added.times(v), v

    @cached_property
    def _doubt_of_added(self) -> Array:
        """(m, m) covariance of v given the errors."""
        assert self.added is not None
        m, together = self.added.values.shape[2], 16  # columns at once
        known = np.zeros((m, m))
        for first in range(0, m, together):
            own = self.added.times(np.eye(m)[:, first : first + together])
            known[:, first : first + together] = self.added.against(self.weight[:, :, None] * self._beside_offsets(own))
        return np.asarray(np.linalg.inv(np.eye(m) + 0.5 * (known + known.T)), dtype=np.float64)

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
