"""The scale of what currents tell: k_T, and with it every torque, mass and friction, where no torque fixes it.

Least squares in amperes knows a joint's parameters only as θ / k_T: with all of them, k_T included, times any factor
the currents stay the same. Only the prior tells the factor, and the point where it is largest is not where the factor
is likely: the more parameters deviate from what was stated, each by what its doubt allows, the nearer to zero a common
factor brings them to the stated values. What is asked for is the factor whatever the other parameters are, so these
are integrated out. Given k_T, the information on them grows as 1/k_T²; the integral adds D_j ln k_j to the logarithm
of the posterior, D_j being the number of parameters that the rows of joint j decide. Where outside forces or torques
fix the scale the term moves k_T by a small share of its standard deviation.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.estimation.least_squares import PriorLeastSquares
from exogauge.estimation.prior import Prior
from exogauge.estimation.statistics import SquareRoot, Statistics
from exogauge.identification.equations import Equations

Array = NDArray[np.float64]

ITERATIONS = 60  # of Newton's method on a convex function; some ten are needed
CONVERGED = 1e-10  # relative


@final
@dataclass(frozen=True)
class GainScale:
    """-2 Σ D_j ln k_j about the solution, as rows of its second-order expansion: √D_j / k_j · k = 2 √D_j.

    axes, columns: (n,) whose current is fitted, and where x holds their k_T. R: (n, P). z: (n,).
    meat: (P, P) what the rows add to the score's covariance.
    """

    axes: tuple[int, ...]
    columns: NDArray[np.intp]
    R: Array
    z: Array
    meat: Array

    def column_of(self, axis: int) -> int | None:
        return int(self.columns[self.axes.index(axis)]) if axis in self.axes else None

    def added_to(self, data: SquareRoot) -> SquareRoot:
        return SquareRoot(np.vstack([data.R, self.R]), np.concatenate([data.z, self.z]), data.rest)


def gain_scale(
    equations: Equations, statistics: Statistics, weights: Array, prior: Prior, strength: float
) -> GainScale:
    """The term where it belongs: at min ‖data‖² + strength ‖prior‖² - 2 Σ D_j ln k_j, a convex problem in k.

    Along a factor that the prior alone decides, its `strength` weighs the term too: the factor is what was stated,
    with the doubt that was stated.
    """
    solved = PriorLeastSquares(statistics.square_root(weights), prior, strength)
    free = prior.free
    kinds, columns = _gains(equations, weights, free)
    n, P = len(columns), len(solved.x)
    if not n:
        return GainScale((), columns, np.zeros((0, P)), np.zeros(0), np.zeros((P, P)))
    believed = strength * (prior.whitening.T @ prior.whitening)
    H = solved.information.T @ solved.information + believed
    at = np.searchsorted(free, columns)
    others = np.setdiff1d(np.arange(len(free)), at)
    own = np.linalg.inv(H[np.ix_(others, others)])
    D, unit = np.empty(n), np.zeros((len(free), n))
    for j, kind in enumerate(kinds):
        R = statistics.square_root(np.where(np.arange(len(weights)) == kind, weights, 0.0)).R[:, free[others]]
        D[j] = np.sum((R @ own) * R)
    unit[at, np.arange(n)] = 1.0
    response = np.linalg.solve(H, unit)  # how x moves with each k, (F, n)
    V = response[at]
    by_prior = np.einsum("fn,fg,gn->n", response, believed, response) / np.diag(V)
    share = D * (1.0 + np.clip(by_prior, 0.0, 1.0) * (strength - 1.0))
    k = _most_likely(solved.x[columns], np.linalg.inv(V), share)
    R_all, meat = np.zeros((n, P)), np.zeros((P, P))
    R_all[np.arange(n), columns] = np.sqrt(share) / k
    meat[columns, columns] = share**2 / np.maximum(D, 1e-300) / k**2
    axes = tuple(kind - equations.first_axis for kind in kinds)
    return GainScale(axes, columns, R_all, 2.0 * np.sqrt(share), meat)


def _gains(equations: Equations, weights: Array, free: NDArray[np.intp]) -> tuple[list[int], NDArray[np.intp]]:
    """Row kinds whose current is logged and that are fitted, and the columns of their k_T."""
    gain = [k for k, effect in enumerate(equations.effects) if effect.name == "motor_gain"]
    kinds, columns = list[int](), list[int]()
    for axis, joint in enumerate(equations.robot.joints):
        column = int(equations.effect_columns(axis)[gain[0]]) if gain else -1
        if joint.actuation == "current" and weights[equations.first_axis + axis] > 0.0 and column in free:
            kinds.append(equations.first_axis + axis)
            columns.append(column)
    return kinds, np.array(columns, dtype=np.intp)


def _most_likely(k_hat: Array, information: Array, D: Array) -> Array:
    """(n,) argmin over k > 0 of (k - k_hat)^T information (k - k_hat) - 2 Σ D ln k, by damped Newton steps."""
    k = np.maximum(k_hat, 0.2 * np.abs(k_hat).max())
    for _ in range(ITERATIONS):
        step = np.linalg.solve(information + np.diag(D / k**2), D / k - information @ (k - k_hat))
        while np.any(k + step <= 0.1 * k):
            step *= 0.5
        k = k + step
        if np.max(np.abs(step) / k) < CONVERGED:
            break
    return np.asarray(k)
