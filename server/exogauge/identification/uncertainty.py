"""The covariance of the weighted score when residuals are coloured: they are not independent from sample to sample."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.equations import Equations
from exogauge.identification.preparation import Prepared
from exogauge.side_by_side import each as side_by_side

Array = NDArray[np.float64]

CORRELATION_TIMES = 8.0  # length of a block in units of the residual's correlation time
SHORTEST_BLOCK_S = 0.5
FEWEST_BLOCKS = 12  # per log; longer blocks would leave too few to estimate a variance from


def score_covariance(equations: Equations, logs: Sequence[Prepared], x: Array, weights: Array) -> Array:
    """(P, P) covariance of Σ w A^T e, from sums over blocks that are long against the residual's memory.

    Blocks of consecutive samples count as independent, samples within a block do not: the clustered form of a
    heteroscedasticity- and autocorrelation-consistent covariance.
    """
    meat = np.zeros((equations.size, equations.size))

    def of_blocks(log: Prepared) -> Array:
        residual = equations.residuals(log, x)
        length = block_length(residual[:, weights > 0.0], log.log.rate_hz / (log.kept[1] - log.kept[0]))
        return equations.scores(log, x, weights, length)

    for sums in side_by_side(of_blocks, logs):
        meat += sums.T @ sums * (len(sums) / (len(sums) - 1.0))
    return meat


def block_length(residual: Array, rate_hz: float) -> int:
    """Samples per block, from the median integral correlation time over the columns of residual: (T, rows)."""
    T = len(residual)
    centred = residual - residual.mean(axis=0)
    spectrum = np.abs(np.fft.rfft(centred, n=2 * T, axis=0)) ** 2
    autocovariance = np.fft.irfft(spectrum, axis=0)[: T // 2]
    rho = autocovariance / np.maximum(autocovariance[0], 1e-300)
    positive = np.cumprod(rho > 0.0, axis=0)  # up to the first zero crossing
    memory = float(np.median(1.0 + 2.0 * np.sum(rho[1:] * positive[1:], axis=0)))
    length = max(CORRELATION_TIMES * memory, SHORTEST_BLOCK_S * rate_hz)
    return int(np.clip(round(length), 1, max(1, T // FEWEST_BLOCKS)))
