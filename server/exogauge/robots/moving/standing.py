"""Where a robot stands that is at home."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from exogauge.errors import BadRobot, Fault
from exogauge.robots.moving.robot import MotionRobot

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


def home_of(robot: MotionRobot) -> Array:
    """(n,). Raises BadRobot where a robot lacks what standing needs."""
    for key, there in (("soles", robot.floating and len(robot.soles) > 1), ("home", robot.home is not None)):
        if not there:
            advice = "Add `soles` of two feet and `home` to robot.yaml, whose base floats: `motion robot` drafts them"
            raise BadRobot(Fault(f"the robot has no {key} to stand with", f"no_{key}", advice, robot.name))
    assert robot.home is not None
    return robot.home


def standing(robot: MotionRobot) -> tuple[pin.SE3, ...]:
    """Poses of the soles' links at home; none of a robot that is bolted down."""
    if not robot.floating:
        return ()
    pin.forwardKinematics(robot.model, robot.data, home_of(robot))
    at = (pin.updateFramePlacement(robot.model, robot.data, robot.frame(sole.link)) for sole in robot.soles)
    return tuple(pin.SE3(pose) for pose in at)


def base_on(robot: MotionRobot, q: Array, stands: BoolArray | None = None) -> Array:
    """(T, 6) coordinates of the base of postures q (T, n) with the feet that stand where they do at home.

    stands: (T, F), in each sample at least one. The first foot that never lifts holds the base, the left one where none
    is given; where every foot lifts at some time, the weight goes over from one to the other while both stand, so that
    what is rounded in a table does not make the base jump.
    """
    share = np.eye(len(robot.soles))[[0] * len(q)] if stands is None else _shares(stands)
    model, data, still = robot.model, robot.data, q.copy()
    still[:, : robot.base] = 0.0
    out = np.zeros((len(q), robot.base))
    for f, place in enumerate(standing(robot)):
        if not share[:, f].any():
            continue
        frame, each = robot.frame(robot.soles[f].link), np.empty((len(q), robot.base))
        turns = np.empty((len(q), 3, 3))
        for t, posture in enumerate(still):
            pin.forwardKinematics(model, data, posture)
            pose = place * pin.updateFramePlacement(model, data, frame).inverse()
            each[t, :3], turns[t] = pose.translation, pose.rotation
        each[:, 3:] = np.unwrap(Rotation.from_matrix(turns).as_euler("ZXY"), axis=0)
        out += share[:, f : f + 1] * each
    return out


def _shares(stands: BoolArray) -> Array:
    """(T, F) of the base: none of a foot that is up, more the longer ago it came down and the later it lifts."""
    always = stands.all(axis=0)
    if always.any():
        return np.eye(stands.shape[1])[[int(always.argmax())] * len(stands)]
    samples = np.arange(len(stands))[:, None]
    apart = np.stack([np.abs(samples - np.flatnonzero(~on)).min(axis=1) for on in stands.T], axis=1).astype(np.float64)
    smooth = apart**3
    return np.asarray(smooth / smooth.sum(axis=1, keepdims=True))
