"""What adds to a joint's torque and is no band's: unknown, near zero, and taken into account in every fit of bands.

    e = A θ + o + V v + n,    o ~ N(0, s²),    v ~ N(0, 1)

o is a constant of one log and joint, γ = W / (W + s⁻²), W = Σ w over its samples, whose weights are w; v are further
unknowns, such as where a via point is, each of which adds its column of V. With both integrated out the score is
Aᵀ w e⊥, the information Aᵀ w A⊥:

    x⊥ = y - γ mean(y),    y = x - V v(x),    v(x) = (1 + Vᵀ w V°)⁻¹ V°ᵀ w x,    V° = V - γ mean(V)

The same as columns of ones and V beside A, each unknown believed to be 0 ± its standard deviation.
"""

from __future__ import annotations

from collections.abc import Sequence
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
        return np.asarray(self._of_each @ np.dot(self._flat, v).reshape(n, -1)).reshape(-1, D, *v.shape[1:])

    def against(self, X: Array) -> Array:
        """(m, …) sums over samples and joints of (N, D, …)."""
        n, D, _ = self.values.shape
        own = np.asarray(self.shares @ X.reshape(len(X), -1)).reshape(n * D, *X.shape[2:])
        return np.asarray(np.dot(self._flat.T, own))

    def sums(self, weight: Array, spans: Sequence[slice]) -> Array:
        """(m, L, D) sums of w V over the samples of each of L spans. weight: (N, D)."""
        of_each = [np.asarray(self.shares[:, span] @ weight[span]) for span in spans]
        told, values = np.stack(of_each).swapaxes(1, 2), self.values.swapaxes(0, 1)
        return np.asarray(np.einsum("ldk,dkm->mld", told, values, optimize=True))

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
    def shares(self) -> Array:
        """(L, D) γ: how much of a mean error is taken for an offset."""
        told = self.total * self.logs.zero_std**2
        return np.asarray(told / (1.0 + told))

    @cached_property
    def doubted(self) -> bool:
        return bool(self.logs.zero_std.any())

    def without(self, X: Array) -> Array:
        """(N, D, …) X⊥: what of errors or slopes is left beside all of this."""
        return self.apart(X)[0]

    def whitened(self, X: Array) -> Array:
        """(N, D, …) X - c mean(X), c = 1 - √(1 - γ): its weighted squares are the information that offsets leave."""
        if not self.doubted:
            return X
        sums = self._by_log(_beside(self.weight, X) * X)
        return self._less_in_each(X, self._likeliest(sums) / _beside(1.0 + np.sqrt(1.0 - self.shares), X))

    def information(self, A: Array) -> Array:
        """(P, P) Aᵀ w A⊥ = Aᵀ w A - Σ γ/W SᵀS - Tᵀ (1 + Vᵀ w V°)⁻¹ T, S sums of w A by log and joint, T = Vᵀ w A°."""
        weighed, P = _beside(self.weight, A) * A, A.shape[2]
        sums = self._by_log(weighed)
        H = np.dot(weighed.reshape(-1, P).T, A.reshape(-1, P))
        if self.doubted:
            H -= self._likeliest(sums).reshape(-1, P).T @ sums.reshape(-1, P)
        if self.added is not None:
            told = self._told_of_added(self.added, weighed, sums)
            H -= told.T @ self._doubt_of_added @ told
        return np.asarray(0.5 * (H + H.T))

    def beside(self, e: Array) -> tuple[Array, float]:
        """(N, D) what of errors is left beside the likeliest of all of this, and what it costs: Σ (o / s)² + Σ v²."""
        left, v, found = self.apart(e)
        std = self.logs.zero_std
        paid = np.divide(found, std, out=np.zeros_like(std), where=std > 0.0)
        return left, float(v @ v + np.sum(paid**2))

    def score_of_offsets(self, told: Array) -> Array:
        """(P, P) of the score, from offsets of the declared size. told: (N, D, P) w A⊥."""
        moved = (self._by_log(told) * self.logs.zero_std[:, :, None]).reshape(-1, told.shape[2])
        return np.asarray(moved.T @ moved)

    def apart(self, X: Array) -> tuple[Array, Array, Array]:
        """(N, D, …) X⊥, (m, …) v(X), and (L, D, …) the likeliest offsets of what is left beside V v."""
        if not self.doubted and self.added is None:
            return X, np.zeros((0, *X.shape[2:])), np.zeros((*self.total.shape, *X.shape[2:]))
        weighed = _beside(self.weight, X) * X
        sums = self._by_log(weighed)
        v = np.zeros((0, *X.shape[2:]))
        if self.added is not None:
            v = self._doubt_of_added @ self._told_of_added(self.added, weighed, sums)
            X, sums = X - self.added.times(v), sums - np.tensordot(self._sums_of_added, v, axes=(0, 0))
        found = self._likeliest(sums)
        return (self._less_in_each(X, found) if self.doubted else X), v, found

    def _told_of_added(self, added: Between, weighed: Array, sums: Array) -> Array:
        """(m, …) V°ᵀ w X = Vᵀ w X°. weighed: (N, D, …) w X; sums: (L, D, …) of it."""
        told = added.against(weighed)
        return np.asarray(told - np.tensordot(self._sums_of_added, self._likeliest(sums), axes=2))

    def _likeliest(self, sums: Array) -> Array:
        """(L, D, …) γ mean(X), of (L, D, …) sums of w X."""
        return _beside(self._of_sums, sums) * sums

    @cached_property
    def _of_sums(self) -> Array:
        """(L, D) γ / W"""
        return np.asarray(self.shares / np.where(self.total > 0.0, self.total, 1.0))

    @cached_property
    def _sums_of_added(self) -> Array:
        """(m, L, D) of w V."""
        assert self.added is not None
        return self.added.sums(self.weight, self.logs.spans)

    @cached_property
    def _doubt_of_added(self) -> Array:
        """(m, m) covariance of v given the errors."""
        assert self.added is not None
        m, together = self.added.values.shape[2], 16  # columns at once
        known = np.zeros((m, m))
        for first in range(0, m, together):
            own = self.added.times(np.eye(m)[:, first : first + together])
            known[:, first : first + together] = self.added.against(self.weight[:, :, None] * own)
        sums = self._sums_of_added
        known -= (sums * self._of_sums).reshape(m, -1) @ sums.reshape(m, -1).T
        return np.asarray(np.linalg.inv(np.eye(m) + 0.5 * (known + known.T)), dtype=np.float64)

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
