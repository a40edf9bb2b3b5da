"""How much more likely the data become when a number of the maker is let go, over all that the stated doubts allow.

A free parameter absorbs a number that is wrong, so no residual shows it. What shows it is how far the data lie from the
prior: the ratio of the marginal likelihoods with and without a broad belief in place of the stated one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
IntArray = NDArray[np.intp]


@final
@dataclass(frozen=True)
class Let:
    """evidence: twice the log ratio. change, std: (k,) of what was let go, in broad beliefs."""

    evidence: float
    change: Array
    std: Array


@final
@dataclass(frozen=True)
class LettingGo:
    """K columns u that changes of the maker's numbers add to the rows y, each as large as a broad belief has it.

    With the rows' marginal covariance C = N + A P A^T: S = u^T C^{-1} u (K, K), g = u^T C^{-1} (y - A mean) (K,).
    """

    S: Array
    g: Array

    def let(self, which: IntArray) -> Let:
        """which: (k,) columns that are let go together, and nothing else."""
        own, V = np.linalg.eigh(self.S[np.ix_(which, which)])
        told = own > 0.0  # the others are rounding: of logs that stand still nothing is left but that
        own, g = np.where(told, own, 0.0), np.where(told, V.T @ self.g[which], 0.0)
        evidence = float(np.sum(g**2 / (1.0 + own)) - np.sum(np.log1p(own)))
        return Let(evidence, V @ (g / (1.0 + own)), np.sqrt(V**2 @ (1.0 / (1.0 + own))))

    def without(self, which: IntArray, share: float | Array = 1.0) -> LettingGo:
        """The same where these columns are free already. share: of the broad belief that they get, at most (k,)."""
        scale = np.broadcast_to(share, len(which))
        S = self.S[:, which] * scale
        inner = np.eye(len(which)) + scale[:, None] * S[which]
        K = np.linalg.solve(inner, S.T)
        return LettingGo(self.S - S @ K, self.g - K.T @ (self.g[which] * scale))
