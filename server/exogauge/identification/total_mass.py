"""What the contact sensors weigh the robot to be, against what its maker says: two numbers that ought to be one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.estimation.prior import Prior
from exogauge.remarks import About, Remark
from exogauge.robots.description import Robot

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class TotalMass:
    """[kg] found: by the logs, of all links together; stated: the sum of the maker's. limit: of |z|, beyond which they
    disagree."""

    found: float
    std: float
    stated: float
    stated_std: float
    limit: float

    @property
    def z(self) -> float:
        return (self.found - self.stated) / float(np.hypot(self.std, self.stated_std))

    @property
    def agrees(self) -> bool:
        return abs(self.z) <= self.limit


def total_mass(robot: Robot, prior: Prior, standard: Array, covariance: Array, limit: float) -> TotalMass | None:
    """None where no sensor bears the robot, or where its mass is not in question. standard: (S,), covariance: (S, S),
    gains of the sensors in it.

    The logs' number has the maker's in it, with next to no weight: both doubts are added as if it had not.
    """
    masses = np.arange(0, robot.tree.phi.size, 10)
    found = covariance[np.ix_(masses, masses)]
    stated_std, std = float(np.linalg.norm(prior.std[masses])), float(np.sqrt(max(float(found.sum()), 0.0)))
    if not (robot.floating and robot.contacts) or not np.hypot(std, stated_std) > 0.0:
        return None
    total, stated = float(standard[masses].sum()), float(prior.mean[masses].sum())
    return TotalMass(total, std, stated, stated_std, limit)


def remarks_on_total_mass(found: TotalMass | None) -> tuple[Remark, ...]:
    if found is None or found.agrees:
        return ()
    return (Remark(About.FEET_AGAINST_MASS, numbers=(found.found, found.std, found.stated, found.stated_std)),)
