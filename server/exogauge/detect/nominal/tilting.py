"""Links across which gravity turns enough to show what they weigh."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from exogauge.identification.model import RobotModel
from exogauge.logs.model import Log
from exogauge.robots.kinematics import forward

BASE_TURNS = 0.02  # rms angular velocity of a floating base [rad/s], below which nothing is claimed of any link
TILTS = 0.15  # rms turn of gravity in a body's frame [rad] that shows its weight
THINNED = 500  # samples of a log looked at


def tilting(model: RobotModel, logs: Sequence[Log]) -> list[int]:
    """Indices of bodies. logs: the fitted ones."""
    up, turning = [], []
    for log in logs:
        prepared = model.prepare(log)
        turning.append(prepared.motion.gyro[prepared.kept])
        kept = prepared.kept[:: max(1, len(prepared.kept) // THINNED)]
        pulled = forward(model.robot.tree, prepared.motion.rows(kept)).proper_acceleration
        up.append(pulled / np.maximum(np.linalg.norm(pulled, axis=2, keepdims=True), 1e-12))
    if model.robot.floating and np.sqrt(np.mean(np.concatenate(turning) ** 2)) < BASE_TURNS:
        return []  # all that its accelerometer says beside gravity is noise
    spread = np.sqrt(np.sum(np.var(np.concatenate(up), axis=0), axis=1))
    return [body for body, each in enumerate(spread) if each > TILTS]
