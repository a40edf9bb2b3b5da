"""Row weights from the noise: each kind of row counts with the inverse of its own residual variance."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from exogauge.estimation.least_squares import PriorLeastSquares
from exogauge.estimation.prior import Prior
from exogauge.estimation.statistics import Statistics
from exogauge.identification.equations import Equations
from exogauge.identification.preparation import Prepared

Array = NDArray[np.float64]

ITERATIONS = 4  # of solving and re-weighting; 3 found noise stds within 3.3 % in trials
FIRST_SHARE = 0.1  # residual as a share of the signal, before anything is known
SMALLEST_SHARE = 1e-6  # of the signal: noise-free data must not give infinite weights


def first_weights(equations: Equations, logs: Sequence[Prepared]) -> Array:
    """(rows,) as if every row's residual were a tenth of what is measured there; 0 for rows without a measurement."""
    robot, first = equations.robot, equations.first_axis
    size = np.zeros(first + len(robot.joints))
    if first:
        moment = np.concatenate([log.wrenches[log.kept].sum(axis=1) for log in logs])
        force = np.sqrt(np.mean(np.sum(moment[:, :3] ** 2, axis=1)))
        size[:3], size[3:6] = force, 0.3 * force
    for axis, joint in enumerate(robot.joints):
        gain = joint.prior.get("k_T", 1.0) if joint.actuation == "current" else 1.0
        drive = np.concatenate([log.drive[log.kept, axis] for log in logs])
        size[first + axis] = abs(gain) * np.sqrt(np.mean(drive**2)) if joint.actuation != "none" else 0.0
    with np.errstate(divide="ignore"):
        return np.where(size > 0.0, (FIRST_SHARE * size) ** -2.0, 0.0)


def weigh(statistics: Statistics, weights: Array, prior: Prior, strength: float) -> Array:
    """(rows,) 1/variance of the residuals, from solving and re-weighting in turn. Rows with weight 0 keep it.

    The noise of the columns counts with the a-priori coefficients: with the estimated ones, a smaller k_T would make
    a row look less noisy and weigh more, and k_T would run away to zero.
    """
    signal = statistics.residual_square_sum(np.zeros(statistics.size)) / statistics.count
    certain = statistics.noise_square_sum(prior.seen_mean) / statistics.count
    live = weights > 0.0
    for _ in range(ITERATIONS):
        x = PriorLeastSquares(statistics.square_root(weights), prior, strength).x
        unexplained = (statistics.residual_square_sum(x) - statistics.noise_square_sum(x)) / statistics.count
        variance = np.maximum(unexplained, 0.0) + certain
        weights = np.where(live, 1.0 / np.maximum(variance, SMALLEST_SHARE**2 * signal + 1e-300), 0.0)
    return weights
