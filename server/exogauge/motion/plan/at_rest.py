"""Whether a robot can stand still where a motion begins and ends: what it cannot, no motion can."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.optimize import linprog
from scipy.spatial import ConvexHull

from exogauge.criteria.motion_plan import HALF_FOOT_M, MotionPlan
from exogauge.motion.plan.rows import sole_rows
from exogauge.robots.moving.robot import MotionRobot, Sole
from exogauge.robots.moving.standing import home_of

Array = NDArray[np.float64]
PRESSURE = "centre of pressure"
MARGINS = 12  # halvings of a margin: to .1 mm


@final
@dataclass(frozen=True)
class AtRest:
    """excess: share of a bound by which the worst is exceeded, however the feet share the load. what: that bound;
    needs, bears: what it takes and what there is [N·m, N], of the centre of pressure the margin asked and the largest
    that can be kept [m]. hopeless: no posture near this one bears it either."""

    excess: float
    what: str
    needs: float
    bears: float
    hopeless: bool

    def __str__(self) -> str:
        if self.what == PRESSURE:
            return (f"centre of pressure: {1e3 * self.needs:.0f} mm inside the soles are asked, at home they allow "
                    f"{1e3 * self.bears:.0f}")  # fmt: skip
        return (f"torque of {self.what}: {self.needs:.3g} to stand still at home, {self.bears:.3g} is its bound: it "
                f"takes {self.needs / self.bears:.1f} times as much")  # fmt: skip


def at_home(robot: MotionRobot, criteria: MotionPlan) -> AtRest:
    """Least excess over the feet's wrenches: a linear programme of one posture, with the rows of a plan."""
    excess, joint, needs = _least(robot, criteria)
    if joint is not None:
        bound = float(robot.limits.torque[joint])
        return AtRest(excess, robot.joints[joint], needs, bound, excess > criteria.hopeless)
    low, high = -criteria.margin_m, criteria.margin_m
    for _ in range(MARGINS):
        middle = 0.5 * (low + high)
        kept = _least(robot, replace(criteria, margin_m=middle))
        low, high = (middle, high) if kept[0] < 1e-6 or kept[1] is not None else (low, middle)
    widest = max(_half_width(sole) for sole in robot.soles)
    return AtRest(excess, PRESSURE, criteria.margin_m, low, excess > 0.0 and criteria.margin_m > widest)


def _half_width(sole: Sole) -> float:
    """[m] radius of the largest circle inside the outline."""
    hull = ConvexHull((sole.outline - sole.middle) @ sole.axes[:, :2]).equations
    found: Any = linprog([0.0, 0.0, -1.0], np.column_stack([hull[:, :2], np.ones(len(hull))]), -hull[:, 2],
                         bounds=[(None, None)] * 2 + [(0.0, None)])  # fmt: skip
    return float(found.x[2])


def _least(robot: MotionRobot, criteria: MotionPlan) -> tuple[float, int | None, float]:
    """Excess, the joint (None: a sole) that is exceeded most dearly, and its torque then."""
    model, data, q = robot.model, robot.data, home_of(robot)
    none = np.zeros(model.nv)
    tau = pin.rnea(model, data, q, none, none)
    pin.computeJointJacobians(model, data, q)
    J = np.concatenate([pin.getFrameJacobian(model, data, robot.frame(sole.link), pin.LOCAL) for sole in robot.soles])
    base, F = robot.base, len(robot.soles)
    bound = criteria.kept * robot.limits.torque
    turn = -robot.weight * J[:, base:].T / bound[:, None]  # by the wrenches, in weights
    feet = np.zeros((0, 6 * F))
    for f, sole in enumerate(robot.soles):
        part = sole_rows(sole, criteria.friction, criteria.margin_m) / HALF_FOOT_M
        feet = np.concatenate([feet, np.pad(part, ((0, 0), (6 * f, 6 * (F - 1 - f))))])
    rows = np.concatenate([turn, -turn, feet])
    used = tau[base:] / bound
    found: Any = linprog(
        np.append(np.zeros(6 * F), 1.0), np.column_stack([rows, -np.ones(len(rows))]),
        np.concatenate([1.0 - used, 1.0 + used, np.zeros(len(feet))]),
        np.column_stack([J[:, :base].T, np.zeros(base)]), tau[:base] / robot.weight,
        [(None, None)] * 6 * F + [(0.0, None)],
    )  # fmt: skip
    dearest = int(found.ineqlin.marginals.argmin())
    if dearest >= 2 * len(used):
        return float(found.fun), None, 0.0
    joint = dearest % len(used)
    return float(found.fun), joint, float(abs((used + turn @ found.x[:-1])[joint] * bound[joint]))
