"""The covariance of the weighted score when residuals are coloured: they are not independent from sample to sample."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.equations import Chunk, Equations
from exogauge.identification.preparation import Prepared
from exogauge.identification.solution import Solution
from exogauge.side_by_side import each as side_by_side

Array = NDArray[np.float64]
IntArray = NDArray[np.intp]

CORRELATION_TIMES = 8.0  # length of a block in units of the residual's correlation time
SHORTEST_BLOCK_S = 0.5
FEWEST_BLOCKS = 12  # per log; longer blocks would leave too few to estimate a variance from


def score_covariance(equations: Equations, logs: Sequence[Prepared], solution: Solution) -> Array:
    """(P, P) covariance of Σ w A^T e, from sums over blocks that are long against the residual's memory.

    Blocks of consecutive samples count as independent, samples within a block do not: the clustered form of a
    heteroscedasticity- and autocorrelation-consistent covariance. Two things make it too small, and are taken back:
    a fit bends to each block, so that what is left there is less than its error, (I - M) of it with M = w A H⁻¹ Aᵀ.
    The score is given (I - M)^-½ of itself, to first order s + ½ H_b H⁻¹ s, H_b the block's own part of the curvature.
    And the ends of a block of length L belong to the errors of its neighbours: of noise with the integral correlation
    time m a block's sum has 1 - m / 2L of what long ones have.
    The rows are those whose curvature H is. Of other ones, an iteration on, the direction that currents leave open is
    another: what H knows next to nothing of got a score, and masses a doubt of fifty times what was stated of them.
    """
    x, before, weights = solution.solved.x, solution.x_before, solution.weights
    meat = np.zeros((equations.size, equations.size))

    def of_blocks(log: Prepared) -> Array:
        residual = equations.residuals(log, x)
        length, memory = block_length(residual[:, weights > 0.0], log.log.rate_hz / (log.kept[1] - log.kept[0]))
        sums = equations.stretches(log, before, weights, length, lambda chunk, _: chunk.residual(x))
        steps = solution.unbounded.divided(sums.T).T
        bent = equations.stretches(log, before, weights, length, lambda *rows: _moved(steps, *rows))
        return np.asarray((sums + 0.5 * bent) / np.sqrt(1.0 - 0.5 * min(memory / length, 1.0)))

    for sums in side_by_side(of_blocks, logs):
        meat += sums.T @ sums * (len(sums) / (len(sums) - 1.0))
    return meat


def _moved(steps: Array, chunk: Chunk, stretch: IntArray) -> Array:
    """(n,) A times the step of the stretch that each row lies in. steps: (stretches, P)."""
    return np.asarray(np.einsum("nk,nk->n", chunk.block[:, :-1], steps[np.ix_(stretch, chunk.columns)]))


def block_length(residual: Array, rate_hz: float) -> tuple[int, float]:
    """Samples per block, and the median integral correlation time over the columns of residual: (T, rows)."""
    T = len(residual)
    centred = residual - residual.mean(axis=0)
    spectrum = np.abs(np.fft.rfft(centred, n=2 * T, axis=0)) ** 2
    autocovariance = np.fft.irfft(spectrum, axis=0)[: T // 2]
    rho = autocovariance / np.maximum(autocovariance[0], 1e-300)
    positive = np.cumprod(rho > 0.0, axis=0)  # up to the first zero crossing
    memory = float(np.median(1.0 + 2.0 * np.sum(rho[1:] * positive[1:], axis=0)))
    length = max(CORRELATION_TIMES * memory, SHORTEST_BLOCK_S * rate_hz)
    return int(np.clip(round(length), 1, max(1, T // FEWEST_BLOCKS))), memory
