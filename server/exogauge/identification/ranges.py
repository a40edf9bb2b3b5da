"""Coefficients that nature bounds: friction does not push, a motor gain is not negative."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from exogauge.estimation.least_squares import PriorLeastSquares
from exogauge.estimation.statistics import SquareRoot
from exogauge.identification.equations import Equations

Array = NDArray[np.float64]

SLACK = 1e-6  # of the prior std: rounding is no reason to hold anything


def solve_within_ranges(
    equations: Equations, data: SquareRoot, nearest: PriorLeastSquares, step: Array
) -> tuple[PriorLeastSquares, tuple[str, ...]]:
    """(solution, names held at a bound). What leaves its range is held at the bound, and the rest solved again.

    nearest: least squares with the prior, of these data; it is moved. step: (P,) from there to the solution
    (`gain_scale`).
    """
    prior, solved = nearest.prior, nearest
    first = equations.base_size
    low, high = _ranges(equations)
    held = np.zeros(len(low), dtype=bool)
    slack = SLACK * prior.std[-len(low) :]
    belief = prior
    while True:
        solved.shift(step)
        xi = solved.x[first:]
        outside = ((xi < low - slack) | (xi > high + slack)) & ~held & (prior.std[-len(low) :] > 0.0)
        if not outside.any():
            return solved, tuple(np.array(_names(equations))[held])
        held |= outside
        mean, std = belief.mean.copy(), belief.std.copy()
        mean[-len(low) :][outside] = np.clip(xi, low, high)[outside]
        std[-len(low) :][outside] = 0.0
        belief = replace(prior, mean=mean, std=std)
        solved = PriorLeastSquares(data, belief, nearest.strength)


def clip_to_ranges(equations: Equations, xi: Array) -> Array:
    """xi: (A·K + E,) joint parameters, each moved to the nearest possible value."""
    return np.asarray(np.clip(xi, *_ranges(equations)))


def _ranges(equations: Equations) -> tuple[Array, Array]:
    """(A·K + E,) lowest and highest value of every joint parameter."""
    axes = len(equations.robot.joints)
    low = np.tile([effect.coefficient.low for effect in equations.effects], axes)
    high = np.tile([effect.coefficient.high for effect in equations.effects], axes)
    return (
        np.concatenate([low, [column.coefficient.low for column in equations.added]]),
        np.concatenate([high, [column.coefficient.high for column in equations.added]]),
    )


def _names(equations: Equations) -> list[str]:
    joints = equations.robot.joints
    own = [f"{effect.coefficient.name}[{joint.name}]" for joint in joints for effect in equations.effects]
    return own + [f"{column.name}[{column.place}]" for column in equations.added]
