"""Two neighbouring axes as one place for effects: what turns with both joints takes its torque from both rows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np
from numpy.typing import NDArray

from exogauge.effects.pair import PairSignals
from exogauge.effects.shaped import AxisSignals
from exogauge.identification.axis_signals import axis_signals
from exogauge.identification.equations import Equations
from exogauge.identification.preparation import Prepared
from exogauge.identification.site import Seen
from exogauge.robots.description import Robot

if TYPE_CHECKING:
    from exogauge.identification.model import RobotModel

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class PairSite:
    """axis: the one further from the base, by whose joint the pair is called. other: the driven one before it."""

    axis: int
    other: int

    def label(self, equations: Equations) -> tuple[str, str, str]:
        return "joint", equations.robot.joints[self.axis].name, ""

    def kinds(self, equations: Equations) -> tuple[int, ...]:
        return (equations.layout.axis(self.axis), equations.layout.axis(self.other))

    def see(self, model: RobotModel, prepared: Prepared) -> Seen:
        return seen_of_pair(*axis_signals(model, prepared, [self.axis, self.other]))

    def in_si(self, model: RobotModel, unit: str, shape: tuple[float, ...]) -> tuple[float, str]:
        return 1.0, unit


def seen_of_pair(own: AxisSignals, other: AxisSignals) -> Seen:
    signals = PairSignals(own, other)
    return Seen(signals, lambda effect, shape: np.asarray(effect.columns(signals, shape)))


def neighbours(robot: Robot) -> list[PairSite]:
    """Every driven joint with the next driven one on its way to the base."""
    tree, found = robot.tree, list[PairSite]()
    for body, axis in enumerate(tree.dof):
        if axis < 0 or robot.joints[axis].actuation == "none":
            continue
        above = int(tree.parent[body])
        while above >= 0 and (tree.dof[above] < 0 or robot.joints[tree.dof[above]].actuation == "none"):
            above = int(tree.parent[above])
        if above >= 0:
            found.append(PairSite(int(axis), int(tree.dof[above])))
    return found
