"""How far joints may go in a planned motion: from a posture of the logs, within the limits that the maker states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.model import RobotModel
from exogauge.logs.model import Log
from exogauge.robots.description import Robot

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Room:
    """(J,) each, [rad or m] and [rad/s or m/s]. posture: one of the fitted logs', amid all of them.

    low, high: where planned motions stay. seen_low, seen_high, seen_speed: of the fitted logs. top_speed: of planned
    motions. free: bool, joints that do not carry the robot. resting: channel -> value while nothing moves.
    rate_hz: of the logs.
    """

    posture: Array
    low: Array
    high: Array
    seen_low: Array
    seen_high: Array
    seen_speed: Array
    top_speed: Array
    free: NDArray[np.bool_]
    resting: Mapping[str, float]
    rate_hz: float


def room(model: RobotModel, logs: Sequence[Log]) -> Room:
    """logs: that were fitted."""
    robot, tree, criteria = model.robot, model.robot.tree, model.criteria.planning
    names = [f"q.{joint.name}" for joint in robot.joints]
    positions = [log.stack(names) for log in logs]
    q = np.concatenate(positions)
    seen_low, seen_high = np.quantile(q, [0.005, 0.995], axis=0)
    middle, spread = np.median(q, axis=0), np.maximum(seen_high - seen_low, 1e-3)
    posture = q[int(np.argmin(np.sum(((q - middle) / spread) ** 2, axis=1)))]
    speed = np.max(
        [_top_speed(each, log.rate_hz, criteria.top) for each, log in zip(positions, logs, strict=True)], axis=0
    )
    known = np.isfinite(tree.lower) & np.isfinite(tree.upper)
    inset = np.where(known, criteria.margin * (tree.upper - tree.lower), 0.0)
    low = np.where(known, tree.lower + inset, seen_low)
    high = np.where(known, tree.upper - inset, seen_high)
    top = np.minimum(criteria.times_seen * speed, criteria.of_top * tree.velocity_limit)
    resting = {name: float(np.median(np.concatenate([log.channels[name] for log in logs])))
               for name in logs[0].channels if all(name in log.channels for log in logs)}  # fmt: skip
    return Room(
        posture=np.clip(posture, np.minimum(low, high), np.maximum(low, high)),
        low=low,
        high=high,
        seen_low=np.clip(seen_low, low, high),
        seen_high=np.clip(seen_high, low, high),
        seen_speed=np.minimum(speed, top),
        top_speed=top,
        free=~carrying(robot),
        resting=resting | dict.fromkeys(("gyro.x", "gyro.y", "gyro.z"), 0.0),
        rate_hz=float(np.median([log.rate_hz for log in logs])),
    )


def carrying(robot: Robot) -> NDArray[np.bool_]:
    """(J,) joints between a floating base and a contact sensor: legs."""
    tree, legs = robot.tree, np.zeros(len(robot.joints), dtype=bool)
    if not robot.floating:
        return legs
    beyond = tree.subtree  # (N, N) whether the second is on the first
    for sensor in robot.contacts:
        foot = tree.frames[sensor.frame][0]
        above = np.flatnonzero(beyond[:, foot] & (tree.dof >= 0)) if foot >= 0 else np.zeros(0, dtype=np.intp)
        legs[tree.dof[above]] = True
    return legs


def _top_speed(q: Array, rate_hz: float, top: float) -> Array:
    """(J,) so fast, or nearly so, as a log ever is."""
    step_s = 0.1  # over which speed is taken
    step = max(1, round(step_s * rate_hz))
    if len(q) <= step:
        return np.zeros(q.shape[1])
    return np.asarray(np.quantile(np.abs(q[step:] - q[:-step]), top, axis=0) * rate_hz / step)
