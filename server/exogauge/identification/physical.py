"""The same equations, solved among robots that can exist: every link's pseudo-inertia positive definite."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.estimation.least_squares import PriorLeastSquares
from exogauge.estimation.physical import solve_physical
from exogauge.remarks import About, Remark
from exogauge.robots.description import Robot

Array = NDArray[np.float64]


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
