"""The factor common to torques, masses, friction and k_T that currents leave open, and what fixes it.

Without a measured force (φ, ξ) times any factor explains currents as well ([Evaluator] 3.1; rank deficit of exactly
one). A contact wrench on the base rows, what a sensor carries, or a joint torque fixes it; so does a weighed load that
some of the fitted logs carry: what the currents are in these logs more than in the others is what it weighs.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.estimation.least_squares import PriorLeastSquares
from exogauge.identification.added_columns import MASS, inseparable_loads
from exogauge.identification.equations import Equations
from exogauge.identification.gain_scale import gain_scale
from exogauge.identification.solution import Solution
from exogauge.remarks import About, Remark
from exogauge.robots.description import Robot

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class CommonFactor:
    """measured: a force or torque fixes it. std: of its logarithm; unweighed: what it would be if no load were known;
    both None where it is measured. A doubt of the whole is none that is worth halving. fixed: share of it that a load
    may leave that fixes the factor."""

    measured: bool = True
    std: float | None = None
    unweighed: float | None = None
    fixed: float = 0.0

    @property
    def known(self) -> bool:
        return self.measured or (
            self.std is not None and self.unweighed is not None and self.std <= self.fixed * min(self.unweighed, 1.0)
        )


def scale_is_measured(robot: Robot) -> bool:
    """Whether a measured force or torque fixes the scale of all torques."""
    contact = robot.floating and bool(robot.contacts)
    return contact or bool(robot.cuts) or any(joint.actuation == "torque" for joint in robot.joints)


def common_factor(equations: Equations, solution: Solution, meat: Array) -> CommonFactor:
    """meat: (P, P) covariance of the weighted score (`uncertainty`)."""
    if scale_is_measured(equations.robot) or not len(solution.gains.columns):
        return CommonFactor(measured=scale_is_measured(equations.robot))
    criteria = equations.criteria.identifying
    std = _std(solution.unbounded.covariance(meat) + solution.gains.doubt, solution)
    masses = [e for e, column in enumerate(equations.added) if column.name == MASS]
    if not masses:
        return CommonFactor(False, std, std, criteria.fixed)
    prior, places = solution.prior, np.array(masses) - len(equations.added) + len(solution.prior.std)
    broad = prior.std.copy()
    broad[places] = criteria.never_weighed * prior.mean[places]
    data = solution.statistics.square_root(solution.weights)
    nearest = PriorLeastSquares(data, replace(prior, std=broad), solution.strength)
    gains = gain_scale(equations, solution.statistics, solution.weights, nearest)
    return CommonFactor(False, std, _std(nearest.covariance(meat) + gains.doubt, solution), criteria.fixed)


def _std(covariance: Array, solution: Solution) -> float:
    """Of the mean logarithm of all k_T that are fitted."""
    columns = solution.gains.columns
    mean = 1.0 / (len(columns) * solution.solved.x[columns])
    return float(np.sqrt(max(float(mean @ covariance[np.ix_(columns, columns)] @ mean), 0.0)))


def remarks_on_the_factor(robot: Robot, factor: CommonFactor, fitted: Sequence[str]) -> list[Remark]:
    """That it is open, once, and why each load that was stated does not fix it. fitted: recordings."""
    if factor.measured:
        return []
    remarks = [] if factor.known else [Remark(About.FACTOR_OPEN)]
    inseparable = inseparable_loads(robot, fitted)
    taken = tuple(math.nan if each is None else each for each in (factor.unweighed, factor.std))
    for load in robot.loads:
        if not set(load.logs) & set(fitted):
            remarks.append(Remark(About.LOAD_NOT_FITTED, (load.name,), ((load.mass,),)))
        elif load.name in inseparable:
            remarks.append(Remark(About.LOAD_IN_EVERY_LOG, (load.name,), ((load.mass,),)))
        elif not factor.known:
            remarks.append(Remark(About.LOAD_FELT_TOO_LITTLE, (load.name,), ((load.mass,),), numbers=taken))
    return remarks
