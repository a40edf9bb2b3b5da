"""The scale of what currents tell: k_T, and with it every torque, mass and friction, where no torque fixes it.

Least squares in amperes knows a joint's parameters only as θ / k_T: with all of them, k_T included, times any factor
the currents stay the same. Only what was stated tells the factor. The nearest point to it, which least squares with a
prior finds, is too small: among s θ it is at s = (θᵀ W m) / (θᵀ W θ), where every way in which the true θ deviates
from the stated m makes the denominator larger. The factor at which the stated values are right on average has
(s θ - m)ᵀ W m = 0: then s θ = m + δ, E δ = 0 gives s = 1, however large δ is. To the slope of the squared distance
along ln s, (s θ - m)ᵀ W (s θ), that is the distance (s θ - m)ᵀ W (s θ - m) too little. So the ln k_j together get the
distance as a slope, each by the number of parameters that its rows decide. What is known of the scale is what the
stated values tell, not how far the identified ones lie from them: the distance is taken off the information too. Where
outside forces, torques or a weighed load fix the scale the term moves k_T by a small share of its standard deviation:
what was weighed is no value that a maker states, and takes no part in the distance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.estimation.least_squares import PriorLeastSquares
from exogauge.estimation.statistics import Statistics
from exogauge.identification.equations import Equations

Array = NDArray[np.float64]

ITERATIONS = 100  # the distance and the factors in turn; some twenty are needed
NEWTON = 60  # steps, on a convex function
CONVERGED = 1e-6  # relative


@final
@dataclass(frozen=True)
class GainScale:
    """axes, columns: (n,) whose current is fitted, and where x holds their k_T.

    step: (P,) from the nearest point to the one that is right on average. doubt: (P, P) what is added to the covariance
    of x: how far the deviations tell the scale is known no better than they are.
    """

    axes: tuple[int, ...]
    columns: NDArray[np.intp]
    step: Array
    doubt: Array

    def column_of(self, axis: int) -> int | None:
        return int(self.columns[self.axes.index(axis)]) if axis in self.axes else None


def gain_scale(equations: Equations, statistics: Statistics, weights: Array, solved: PriorLeastSquares) -> GainScale:
    """solved: the nearest point, from these statistics with these weights. Along a factor that the prior alone decides
    its `strength`, which data have chosen, is of no account: it weighs the term too."""
    prior, strength, free = solved.prior, solved.strength, solved.prior.free
    axes, columns = _gains(equations, weights, free)
    kinds = [equations.layout.axis(axis) for axis in axes]
    n, P = len(columns), len(solved.x)
    if not n:
        return GainScale((), columns, np.zeros(P), np.zeros((P, P)))
    G, W = solved.information.T @ solved.information, prior.information(1.0)
    H = G + prior.information(strength)
    W[prior.measured_free], W[:, prior.measured_free] = 0.0, 0.0  # scales are read, not stated by a maker
    at = np.searchsorted(free, columns)
    others = np.setdiff1d(np.arange(len(free)), at)
    of_maker = ~np.isin(others, prior.measured_free)
    unit = np.zeros((P, len(free)))
    unit[free, np.arange(len(free))] = 1.0
    H_inverse: Array = solved.divided(unit)[free]  # not of H itself: squared, a short or slow log leaves no digit
    V = H_inverse[np.ix_(at, at)]
    response = H_inverse[:, at] @ np.linalg.inv(V)  # of x to each k, (F, n)
    number = 1.0 + _decided_by(statistics, weights, kinds, free[others], H[np.ix_(others, others)], of_maker)
    by_prior = strength * np.einsum("fn,fg,gn->n", response, W, response) * np.diag(V)
    weight = np.asarray(1.0 + np.clip(by_prior, 0.0, 1.0) * (strength - 1.0))
    x_hat, m = solved.x[free], prior.seen_mean[free]
    information, k_hat = np.asarray(np.linalg.inv(V), np.float64), x_hat[at]
    k = np.asarray(np.maximum(k_hat, 0.2 * np.abs(k_hat).max()))
    for _ in range(ITERATIONS):
        off = x_hat + response @ (k - k_hat) - m
        distance = number * min(1.0, float(off @ W @ off) / float(number.sum()))
        before, k = k, most_likely(k_hat, information, weight * np.maximum(distance, 0.0), k)
        if np.max(np.abs(k - before) / k) < CONVERGED:
            break
    step, doubt = np.zeros(P), np.zeros((P, P))
    step[free] = response @ (k - k_hat)
    added = _less_known(
        solved.covariance()[np.ix_(columns, columns)],
        np.maximum(distance, 0.0) / k**2,
        equations.criteria.identifying.gain_known,
    )
    doubt[np.ix_(free, free)] = response @ added @ response.T
    return GainScale(tuple(axes), columns, step, doubt)


def most_likely(k_hat: Array, information: Array, slope: Array, start: Array) -> Array:
    """(n,) argmin over k > 0 of (k - k_hat)ᵀ information (k - k_hat) - 2 Σ slope ln k, by damped Newton steps."""
    k = start
    for _ in range(NEWTON):
        step = np.linalg.solve(information + np.diag(slope / k**2), slope / k - information @ (k - k_hat))
        while np.any(k + step <= 0.1 * k):
            step *= 0.5
        k = k + step
        if np.max(np.abs(step) / k) < 1e-3 * CONVERGED:
            break
    return np.asarray(k)


def _less_known(V: Array, less: Array, most: float) -> Array:
    """(n, n) (V⁻¹ - diag(less))⁻¹ - V. less: (n,), of which `most` can be taken off."""
    root = np.linalg.cholesky(V)
    share, turned = np.linalg.eigh(root.T @ (less[:, None] * root))
    share = np.clip(share, 0.0, most)
    half = root @ turned
    return np.asarray((half * (share / (1.0 - share))) @ half.T)


def _decided_by(
    statistics: Statistics,
    weights: Array,
    kinds: Sequence[int],
    columns: NDArray[np.intp],
    H: Array,
    counted: NDArray[np.bool_],
) -> Array:
    """(n,) Σ (H⁻¹ w AᵀA)_oo over the counted ones of these columns: how many each kind's own rows decide.

    columns: (O,) of x. H: (O, O) what is known of them. counted: (O,).
    """
    inverse, found = np.linalg.inv(H), []
    for kind in kinds:
        own = statistics.columns[kind]
        seen = np.isin(own, columns)
        place = np.searchsorted(columns, own[seen])
        information = weights[kind] * statistics.gram(kind)[np.ix_(seen, seen)]
        shares = np.sum(inverse[np.ix_(place, place)] * information.T, axis=1)
        found.append(float(shares[counted[place]].sum()))
    return np.array(found)


def _gains(equations: Equations, weights: Array, free: NDArray[np.intp]) -> tuple[list[int], NDArray[np.intp]]:
    """Axes whose current is logged and that are fitted, and the columns of their k_T."""
    gain = [k for k, effect in enumerate(equations.effects) if effect.name == "motor_gain"]
    axes, columns = list[int](), list[int]()
    for axis, joint in enumerate(equations.robot.joints):
        column = int(equations.effect_columns(axis)[gain[0]]) if gain else -1
        if joint.actuation == "current" and weights[equations.layout.axis(axis)] > 0.0 and column in free:
            axes.append(axis)
            columns.append(column)
    return axes, np.array(columns, dtype=np.intp)
