"""Row weights from the noise: each kind of row counts with the inverse of its own residual variance."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.estimation.least_squares import PriorLeastSquares
from exogauge.estimation.prior import Prior
from exogauge.estimation.statistics import Statistics
from exogauge.identification.equations import Equations

Array = NDArray[np.float64]

ITERATIONS = 4  # of solving and re-weighting; 3 found noise stds within 3.3 % in trials
SMALLEST_SHARE = 1e-6  # of the signal: noise-free data must not give infinite weights


def weigh(statistics: Statistics, prior: Prior, strength: float, weights: Array) -> Array:
    """(rows,) 1/variance of the residuals, from solving and re-weighting in turn. Rows with weight 0 keep it."""
    seen = np.maximum(statistics.count, 1)
    signal = statistics.residual_square_sum(prior.seen_mean) / seen
    live = weights > 0.0
    for _ in range(ITERATIONS):
        x = PriorLeastSquares(statistics.square_root(weights), prior, strength).x
        variance = statistics.residual_square_sum(x) / seen
        weights = np.where(live, 1.0 / np.maximum(variance, SMALLEST_SHARE**2 * signal + 1e-300), 0.0)
    return weights


def first_weights(equations: Equations, statistics: Statistics, prior: Prior) -> Array:
    """(rows,) from what the a-priori robot leaves unexplained.

    0 for joints whose torque is not logged, and for axes that are not in steady motion (see `static_friction`).
    """
    variance = statistics.residual_square_sum(prior.seen_mean) / np.maximum(statistics.count, 1)
    measured = statistics.count > 0
    measured[equations.layout.axes] &= np.array([joint.actuation != "none" for joint in equations.robot.joints])
    measured[equations.layout.at_rest] = False
    return np.where(measured, 1.0 / np.maximum(variance, 1e-300), 0.0)
