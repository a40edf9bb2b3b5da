"""Where a robot stands that is at home."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from exogauge.errors import BadRobot, Fault
from exogauge.robots.moving.robot import MotionRobot

Array = NDArray[np.float64]


def home_of(robot: MotionRobot) -> Array:
    """(n,). Raises BadRobot where a robot lacks what standing needs."""
    for key, there in (("soles", robot.floating and len(robot.soles) > 1), ("home", robot.home is not None)):
        if not there:
            advice = "Add `soles` of two feet and `home` to robot.yaml, whose base floats"
            raise BadRobot(Fault(f"the robot has no {key} to stand with", f"no_{key}", advice, robot.name))
    assert robot.home is not None
    return robot.home


def standing(robot: MotionRobot) -> tuple[pin.SE3, ...]:
    """Poses of the soles' links at home."""
    pin.forwardKinematics(robot.model, robot.data, home_of(robot))
    at = (pin.updateFramePlacement(robot.model, robot.data, robot.frame(sole.link)) for sole in robot.soles)
    return tuple(pin.SE3(pose) for pose in at)


def base_on(robot: MotionRobot, q: Array) -> Array:
    """(T, 6) coordinates of the base of postures q (T, n) with the left foot where it stands at home."""
    model, data, frame = robot.model, robot.data, robot.frame(robot.soles[0].link)
    place, still = standing(robot)[0], q.copy()
    still[:, : robot.base] = 0.0
    out = np.empty((len(q), robot.base))
    turns = np.empty((len(q), 3, 3))
    for t, posture in enumerate(still):
        pin.forwardKinematics(model, data, posture)
        pose = place * pin.updateFramePlacement(model, data, frame).inverse()
        out[t, :3], turns[t] = pose.translation, pose.rotation
    out[:, 3:] = np.unwrap(Rotation.from_matrix(turns).as_euler("ZXY"), axis=0)
    return out
