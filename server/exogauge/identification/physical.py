"""The same equations, solved among robots that can exist: every link's pseudo-inertia positive definite."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.estimation.least_squares import PriorLeastSquares
from exogauge.estimation.physical import solve_physical
from exogauge.identification.prior import relative_std
from exogauge.remarks import About, Remark
from exogauge.robots.description import Robot

Array = NDArray[np.float64]


def possible_parameters(
    robot: Robot, solved: PriorLeastSquares, gains: NDArray[np.intp]
) -> tuple[Array, tuple[Remark, ...]]:
    """((S,) [φ; ξ], remarks). Links are tied to the maker's by a log-det distance, joints as in the free solution.

    The distance's weight 1/(2 ρ²) costs a link's mass scale as much as a relative standard deviation ρ would.
    gains: of x, the k_T that stay as in the free solution: where nothing measured fixes the scale of all torques, that
    was decided there (`gain_scale`), and this distance would decide it anew by its own measure.
    """
    prior, inertial = solved.prior, robot.tree.phi.size
    standard = prior.mean.copy()
    kept = gains + (len(prior.mean) - len(solved.x))
    standard[kept] = solved.x[gains]
    own = np.setdiff1d(np.flatnonzero(prior.std[inertial:] > 0.0) + inertial, kept)
    columns = np.concatenate([np.arange(inertial), own])
    data = solved.information @ prior.seen[prior.free][:, columns]
    belief = np.zeros((len(own), len(columns)))
    belief[:, inertial:] = np.diag(np.sqrt(prior.strengths(solved.strength)[own]) / prior.std[own])
    moved = solved.information @ prior.seen[np.ix_(prior.free, kept)] @ standard[kept]
    target = np.concatenate([solved.target - moved, belief[:, inertial:] @ prior.mean[own]])
    found = solve_physical(
        np.vstack([data, belief]),
        target,
        robot.tree.phi,
        weight=solved.strength / (2.0 * np.maximum(relative_std(robot), 1e-3) ** 2),
        names=robot.tree.bodies,
    )
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
