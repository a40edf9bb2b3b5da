"""Whether a robot can stand still where a motion begins and ends: what it cannot, no motion can."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np
import pinocchio as pin
import scipy
from numpy.typing import NDArray

from exogauge.criteria.motion_plan import HALF_FOOT_M, MotionPlan
from exogauge.motion.plan.rows import sole_rows
from exogauge.robots.moving.robot import MotionRobot
from exogauge.robots.moving.standing import base_on, home_of, standing

Array = NDArray[np.float64]
PRESSURE = "centre of pressure"
MARGINS = 12  # halvings of a margin: to .1 mm
BENDS = 7  # halvings of a share of the legs' bend: to .01, as it is told
FLAT_M = 1e-3  # judgement: by which a corner of a sole may rise in what is proposed; a floor is no flatter


@final
@dataclass(frozen=True)
class AtRest:
    """excess: share of a bound by which the worst is exceeded, however the feet share the load. what: that bound;
    needs, bears: what it takes and what there is [N·m, N], of the centre of pressure the margin asked and the largest
    that can be kept [m]. lacks: bounds by which a plan is judged are broken, not only what is kept of them for
    planning: every motion begins and ends there, so that none can have them. bend: the largest share of its legs'
    angles at which home would bear its own weight, None where none does or nothing is lacking."""

    excess: float
    what: str
    needs: float
    bears: float
    lacks: bool
    bend: float | None = None

    def __str__(self) -> str:
        if self.what == PRESSURE:
            return (f"centre of pressure: {1e3 * self.needs:.0f} mm inside the soles are asked, at home they allow "
                    f"{1e3 * self.bears:.0f}: ask for that, or give a `home` that leans less")  # fmt: skip
        other = "" if self.bend is None else f"with its legs bent {self.bend:.2f} times as far, or "
        return (f"torque of {self.what}: {self.needs:.3g} to stand still at home, {self.bears:.3g} is its bound: it "
                f"takes {self.needs / self.bears:.2f} times as much; give a `home` {other}that takes less")  # fmt: skip


def at_home(robot: MotionRobot, criteria: MotionPlan) -> AtRest:
    """Least excess over the feet's wrenches: a linear programme of one posture, with the rows of a plan; of the bounds
    by which a plan is judged where they are broken, else of what is kept of them."""
    excess, joint, needs = _least(robot, replace(criteria, kept=1.0, margin_m=criteria.inside_m))
    lacks = excess > criteria.beyond
    if not lacks:
        excess, joint, needs = _least(robot, criteria)
    if joint is not None:
        bend = _less_bent(robot, criteria) if lacks else None
        return AtRest(excess, robot.joints[joint], needs, float(robot.limits.torque[joint]), lacks, bend)
    low, high = -criteria.margin_m, criteria.margin_m
    for _ in range(MARGINS):
        middle = 0.5 * (low + high)
        kept = _least(robot, replace(criteria, margin_m=middle))
        low, high = (middle, high) if kept[0] < 1e-6 or kept[1] is not None else (low, middle)
    return AtRest(excess, PRESSURE, criteria.margin_m, low, lacks)


def _less_bent(robot: MotionRobot, criteria: MotionPlan) -> float | None:
    """Straighter legs take less torque; soles that lie flat at home have to lie flat then."""
    legs = np.unique(np.concatenate([robot.leg(foot) for foot in range(len(robot.soles))]))
    flat = _corners(robot)

    def bears(share: float) -> bool:
        home = home_of(robot).copy()
        home[legs] *= share
        home[: robot.base] = base_on(robot, home[None])[0]
        other = replace(robot, home=home)
        lies_flat = np.abs(_corners(other) - flat)[:, 2].max() <= FLAT_M
        return bool(lies_flat) and _least(other, criteria)[0] <= criteria.over

    if not bears(0.0):
        return None
    low, high = 0.0, 1.0
    for _ in range(BENDS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if bears(middle) else (low, middle)
    return low


def _corners(robot: MotionRobot) -> Array:
    """(F K, 3) [m] of the soles at home."""
    return np.concatenate([pose.act(corner)[None] for sole, pose in zip(robot.soles, standing(robot), strict=True)
                           for corner in sole.outline])  # fmt: skip


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
    found: Any = scipy.optimize.linprog(
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
