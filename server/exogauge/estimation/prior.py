"""What is believed before the data, brought to the parameters that the data can see."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import final

import numpy as np
import scipy.linalg as sl
from numpy.typing import NDArray

from exogauge.estimation.statistics import upper_factor

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Prior:
    """Independent beliefs about all S parameters, of which the data see P combinations x = D s.

    mean, std: (S,); std 0 means known, and stays. seen: D (P, S), full row rank.
    measured: (S,) bool, or empty for none: what was measured otherwise, on scales say, and is seen as it is, in no
    combination. Such a belief counts as stated, whatever strength the others are given.
    """

    mean: Array
    std: Array
    seen: Array
    measured: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=bool))

    @cached_property
    def seen_mean(self) -> Array:
        """(P,) D s_ref."""
        return np.asarray(self.seen @ self.mean)

    @cached_property
    def seen_covariance(self) -> Array:
        """(P, P) D W^{-1} D^T with W^{-1} = diag(std²)."""
        return np.asarray((self.seen * self.std**2) @ self.seen.T)

    @cached_property
    def free(self) -> NDArray[np.intp]:
        """Indices of seen combinations that are not known exactly."""
        return np.flatnonzero(np.diag(self.seen_covariance) > 0.0)

    @cached_property
    def whitening(self) -> Array:
        """(F, F) upper triangular U with U^T U = inverse of the free part of `seen_covariance`."""
        P_free = self.seen_covariance[np.ix_(self.free, self.free)]
        scale = np.sqrt(np.diag(P_free))
        L = np.linalg.cholesky(P_free / np.outer(scale, scale))
        inverse = sl.solve_triangular(L, np.eye(len(L)), lower=True) / scale
        return upper_factor(inverse)

    @cached_property
    def measured_free(self) -> NDArray[np.intp]:
        """Places among `free` of what was measured."""
        if not self.measured.any():
            return np.zeros(0, dtype=np.intp)
        return np.flatnonzero(self.seen[self.free][:, self.measured].any(axis=1))

    def strengths(self, strength: float) -> Array:
        """(S,) with which each belief counts."""
        own = np.full(len(self.mean), strength)
        own[: len(self.measured)][self.measured] = 1.0
        return own

    def root(self, strength: float) -> Array:
        """(F, F) R with R^T R = `information`: nothing else is correlated with what was measured."""
        root = np.sqrt(strength) * self.whitening
        root[self.measured_free] = self.whitening[self.measured_free]
        return np.asarray(root)

    def information(self, strength: float) -> Array:
        """(F, F) of the free combinations, where the beliefs count `strength` times."""
        information = strength * self._precision
        information[self.measured_free] = self._precision[self.measured_free]
        return np.asarray(information)

    def lift(self, x: Array) -> Array:
        """(S,) the parameters nearest to the prior (in its own metric) with D s = x.

        What D does not see moves only as far as the prior ties it to what D sees; the rest stays exactly.
        """
        step = np.zeros(len(self.seen_mean))
        step[self.free] = self._precision @ (x - self.seen_mean)[self.free]
        return np.asarray(self.mean + self.std**2 * (self.seen.T @ step))

    def lift_covariance(self, covariance: Array) -> Array:
        """(S, S) covariance of `lift(x)` about the truth, given that of x about its truth."""
        K = self._lifting
        inner = covariance[np.ix_(self.free, self.free)] - self.seen_covariance[np.ix_(self.free, self.free)]
        return np.asarray(np.diag(self.std**2) + K @ inner @ K.T)

    def lifted(self, moved: Array) -> Array:
        """(S, I) by how much `lift(x)` moves where x moves by each column of moved: (X, I)."""
        return np.asarray(self._lifting @ moved[self.free])

    @property
    def _lifting(self) -> Array:
        """(S, free) slope of `lift`."""
        return np.asarray((self.seen[self.free] * self.std**2).T @ self._precision)

    @cached_property
    def _precision(self) -> Array:
        return np.asarray(self.whitening.T @ self.whitening)
