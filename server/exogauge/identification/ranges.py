"""What nature bounds: friction does not push, a motor gain is not negative, a link is a body that can exist."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from exogauge.estimation.least_squares import PriorLeastSquares
from exogauge.estimation.physical import solve_physical
from exogauge.estimation.statistics import SquareRoot
from exogauge.identification.equations import Equations
from exogauge.remarks import About, Remark
from exogauge.robots.description import Robot

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


def possible_parameters(
    robot: Robot, solved: PriorLeastSquares, gains: NDArray[np.intp]
) -> tuple[Array, tuple[Remark, ...]]:
    """((S,) [φ; ξ], remarks). Believed is what the free solution believes, so that the doubt that is stated of that
    holds here too. A log-det distance to the maker's bodies keeps links from the border of what is possible.

    gains: of x, the k_T that stay as in the free solution, where nothing measured fixes the scale of all torques.
    """
    inside = 0.5  # weight of the distance: a link of half its mass and inertia costs as much as .6 standard deviations
    prior, bodies = solved.prior, robot.tree.phi.size
    standard = prior.mean.copy()
    kept = gains + (len(prior.mean) - len(solved.x))
    standard[kept] = solved.x[gains]
    own = np.setdiff1d(np.flatnonzero(prior.std > 0.0), kept)
    columns = np.union1d(np.arange(bodies), own)
    data = solved.information @ prior.seen[prior.free][:, columns]
    belief = np.zeros((len(own), len(columns)))
    belief[np.arange(len(own)), np.searchsorted(columns, own)] = (
        np.sqrt(prior.strengths(solved.strength)[own]) / prior.std[own]
    )
    moved = solved.information @ prior.seen[np.ix_(prior.free, kept)] @ standard[kept]
    target = np.concatenate([solved.target - moved, belief @ prior.mean[columns]])
    found = solve_physical(np.vstack([data, belief]), target, robot.tree.phi, weight=inside, names=robot.tree.bodies)
    standard[columns] = found.x
    return standard, found.remarks


def asked_for_negative_mass(robot: Robot, free: Array, std: Array, sure: float) -> tuple[Remark, ...]:
    """A remark on links that the data alone would give a negative mass: then no possible body explains them.

    free, std: (S,) [φ; ξ] as the data and the prior have it without the demand, and its standard deviation.
    """
    bodies = len(robot.tree.bodies)
    mass, doubt = free[: 10 * bodies : 10], std[: 10 * bodies : 10]
    negative = np.flatnonzero(mass + sure * doubt < 0.0)
    if not negative.size:
        return ()
    names = tuple(robot.tree.bodies[k] for k in negative)
    return (Remark(About.NEGATIVE_MASS, names, tuple((float(mass[k]), float(doubt[k])) for k in negative)),)
