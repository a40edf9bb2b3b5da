"""What a robot's sensors would read over a motion: encoders, the base's IMU, and feet that share the load as evenly as
they can."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.preparation import wrench_channels
from exogauge.robots.description import Robot
from exogauge.robots.motion import Motion
from exogauge.robots.moving.strain import EVENLY
from exogauge.robots.regressor import contact_effect

Array = NDArray[np.float64]


def felt_channels(robot: Robot, motion: Motion, loads: Array) -> dict[str, Array]:
    """Name -> (T,) of a log without noise. loads: (T, 6 …) what the base asks for, of a floating one."""
    channels = {f"q.{joint.name}": motion.q[:, k] for k, joint in enumerate(robot.joints)}
    if not robot.floating or robot.T_base_imu is None:
        return channels
    R, r = robot.T_base_imu.rotation, robot.T_base_imu.translation
    felt = motion.acc + np.cross(motion.gyro_dot, r) + np.cross(motion.gyro, np.cross(motion.gyro, r))
    for axis, name in enumerate("xyz"):
        channels[f"acc.{name}"] = (felt @ R)[:, axis]
        channels[f"gyro.{name}"] = (motion.gyro @ R)[:, axis]
    for sensor, wrench in zip(robot.contacts, feet_wrenches(robot, motion, loads), strict=True):
        for name, column in zip(wrench_channels(sensor.name), sensor.sign * wrench.T, strict=True):
            channels[name] = column
    return channels


def feet_wrenches(robot: Robot, motion: Motion, loads: Array) -> list[Array]:
    """(T, 6) of each contact sensor: the smallest that carry and move the robot."""
    paths = _paths(robot, motion)[:, :6]
    share = np.tile(EVENLY, paths.shape[2] // 6)
    driven = np.einsum("tik,k,tjk->tij", paths, share, paths)
    carried = np.linalg.solve(driven, loads[:, :6, None])
    wrench = share * np.einsum("tik,ti->tk", paths, carried[..., 0])
    return list(np.moveaxis(wrench.reshape(motion.samples, -1, 6), 1, 0))


def borne_by_feet(robot: Robot, motion: Motion, loads: Array) -> Array | None:
    """(T, A) [N·m] of the axes' loads that the feet bear, None of a robot on a base."""
    if not robot.floating:
        return None
    wrench = np.concatenate(feet_wrenches(robot, motion, loads), axis=1)
    joints = np.einsum("tjk,tk->tj", _paths(robot, motion)[:, 6:], wrench)
    return np.asarray(joints @ np.linalg.inv(robot.axes_from_joints))


def _paths(robot: Robot, motion: Motion) -> Array:
    """(T, 6 + J, 6 S) what unit wrenches at the contact sensors do to base and joints."""
    columns = []
    for sensor in robot.contacts:
        for k in range(6):
            unit = np.zeros((motion.samples, 6))
            unit[:, k] = 1.0
            columns.append(contact_effect(robot.tree, motion.q, sensor.frame, unit))
    return np.stack(columns, axis=2)
