"""The same equations, solved among robots that can exist: every link's pseudo-inertia positive definite."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.estimation.least_squares import PriorLeastSquares
from exogauge.estimation.physical import solve_physical
from exogauge.identification.prior import INERTIAL_STD
from exogauge.robots.description import Robot

Array = NDArray[np.float64]


def possible_parameters(robot: Robot, solved: PriorLeastSquares) -> tuple[Array, tuple[str, ...]]:
    """((S,) [φ; ξ], warnings). Links are tied to the maker's by a log-det distance, joints as in the free solution.

    The distance's weight 1/(2 ρ²) costs a link's mass scale as much as a relative standard deviation ρ would.
    """
    prior, inertial = solved.prior, robot.tree.phi.size
    own = np.flatnonzero(prior.std[inertial:] > 0.0) + inertial
    columns = np.concatenate([np.arange(inertial), own])
    data = solved.information @ prior.seen[prior.free][:, columns]
    belief = np.zeros((len(own), len(columns)))
    belief[:, inertial:] = np.diag(np.sqrt(solved.strength) / prior.std[own])
    target = np.concatenate([solved.target, belief[:, inertial:] @ prior.mean[own]])
    rho = np.array([robot.inertial_std.get(b, robot.inertial_std.get("", INERTIAL_STD)) for b in robot.tree.bodies])
    found = solve_physical(
        np.vstack([data, belief]), target, robot.tree.phi, weight=solved.strength / (2.0 * np.maximum(rho, 1e-3) ** 2)
    )
    standard = prior.mean.copy()
    standard[columns] = found.x
    return standard, found.warnings
