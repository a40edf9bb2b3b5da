"""What is had without a plan: each frame by itself, then smoothed. It is shown beside the plan, and never played."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from exogauge.criteria.motion_plan import MotionPlan
from exogauge.motion.plan.asked import Asked
from exogauge.motion.plan.judge import Judged, judge
from exogauge.motion.plan.outcome import slow
from exogauge.motion.plan.solve import Planned
from exogauge.motion.plan.spline import through
from exogauge.robots.moving.robot import MotionRobot

Array = NDArray[np.float64]

FARTHEST = 0.3  # [rad or m] of one step: no further do slopes hold; shorter ones take more rounds to the same end
SETTLED = 1e-5  # [rad or m] a step after which a posture is found: a tenth of what a planned foot may be off
AT_ENDS = 5  # times that joints are sought which the step would lead out of their range
NEGLIGIBLE = 1e-9  # share of what the feet feel of all joints, for rounding: a straight leg feels nothing along itself


def frame_by_frame(
    robot: MotionRobot, asked: Asked, criteria: MotionPlan, rate: float | None
) -> tuple[Planned, Judged]:
    """At each node the posture nearest to what is asked, as `Asked.stray` weighs it, with the soles at their places and
    the joints within their range; then without what is faster than `smooth_hz`, as the plan is. Forces, shapes and the
    other nodes say nothing. Judged as the plan is, at `rate` [Hz].
    """
    q, now = np.empty_like(asked.q), asked.q[0]
    for t, (wanted, place) in enumerate(zip(asked.q, asked.place, strict=True)):
        q[t] = now = _posture(robot, now, wanted, asked.stray, place, criteria)
    stands = None if asked.stands.all() else asked.stands
    unloaded, nothing = np.zeros((len(q), len(robot.soles), 6)), np.zeros(len(q))
    spline = through(slow(q, asked.step, criteria.smooth_hz), asked.step)
    found = Planned(spline, unloaded, nothing, 0, 0.0, stands=stands)
    return found, judge(robot, spline, asked.place[0], criteria, rate, found)


def _posture(
    robot: MotionRobot, begin: Array, wanted: Array, stray: Array, place: tuple[pin.SE3, ...], criteria: MotionPlan
) -> Array:
    """(n,) least sum of ((q - wanted) / stray)² with the soles at `place`, by Gauss and Newton's steps from `begin`;
    a joint that a step would lead out of its range stays at its end, and the others make up for it."""
    model, data, base = robot.model, robot.data, robot.base
    lower = np.concatenate([np.full(base, -np.inf), robot.limits.lower])
    upper = np.concatenate([np.full(base, np.inf), robot.limits.upper])
    asks = np.isfinite(stray)
    wish = np.where(asks, 1.0 / np.where(asks, stray, 1.0), 0.0) ** 2
    weight = wish + 1.0 / criteria.free_rad**2
    q = begin.copy()
    for _ in range(criteria.rounds):
        pin.computeJointJacobians(model, data, q)
        off, slopes = [], []
        for sole, at in zip(robot.soles, place, strict=True):
            frame = robot.frame(sole.link)
            off.append(pin.log6(at.inverse() * pin.updateFramePlacement(model, data, frame)).vector)
            slopes.append(pin.getFrameJacobian(model, data, frame, pin.LOCAL))
        J, e = np.concatenate(slopes), np.concatenate(off)
        pull = wish * (wanted - q) / weight
        free = np.ones(len(q), dtype=bool)
        for _ in range(AT_ENDS):
            step = np.where(free, pull, np.clip(pull, lower - q, upper - q))
            yields = free / weight
            A = (J * yields) @ J.T
            A += NEGLIGIBLE * np.trace(A) * np.eye(len(A))
            step -= yields * (J.T @ np.linalg.solve(A, e + J @ step))
            out = free & ((q + step < lower - SETTLED) | (q + step > upper + SETTLED))
            if not out.any():
                break
            free &= ~out
        step *= min(1.0, FARTHEST / max(float(np.abs(step).max()), SETTLED))
        q = np.clip(q + step, lower, upper)
        if np.abs(step).max() < SETTLED:
            break
    return q
