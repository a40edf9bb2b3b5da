"""Leg angles that keep both feet where they stand, in closed form (hip axes meet in a point, ankle axes too)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.synthetic.robot_facts import ANKLE_HEIGHT, HIP_DROP, HIP_HALF_WIDTH, SHANK, THIGH

Array = NDArray[np.float64]

STANCE_HALF_WIDTH = 0.11  # of the ankles [m]
LEG_JOINTS = ("hip_yaw", "hip_roll", "hip_pitch", "knee_pitch", "ankle_pitch", "ankle_roll")


def rotations(rpy: Array) -> Array:
    """(T, 3, 3) Rz(yaw) Ry(pitch) Rx(roll) for rpy (T, 3) [rad]."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy).T, np.sin(rpy).T
    rows = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def leg_angles(side: float, position: Array, R: Array) -> Array:
    """(T, 6) [rad] in the order of `LEG_JOINTS`; side +1 left, -1 right.

    position: (T, 3) [m], R: (T, 3, 3) of the base in the world; the foot is level and points forward at
    (0, side · STANCE_HALF_WIDTH). A leg that would have to be longer than it is, is stretched.
    """
    ankle = np.array([0.0, side * STANCE_HALF_WIDTH, ANKLE_HEIGHT])
    hip = position + R @ np.array([0.0, side * HIP_HALF_WIDTH, -HIP_DROP])
    x, y, z = (hip - ankle).T  # hip seen from the ankle; the foot frame is the world's
    distance = np.sqrt(x**2 + y**2 + z**2)
    cosine = np.clip((distance**2 - THIGH**2 - SHANK**2) / (2 * THIGH * SHANK), -1.0, 1.0)
    knee = np.arccos(cosine)
    shank_angle = np.arcsin(np.clip(THIGH * np.sin(np.pi - knee) / distance, -1.0, 1.0))
    ankle_roll = np.arctan2(y, z)
    ankle_pitch = -np.arctan2(x, np.hypot(y, z)) - shank_angle

    c, s, zero, one = np.cos(ankle_roll), np.sin(ankle_roll), np.zeros_like(x), np.ones_like(x)
    roll_back = np.moveaxis(np.array([[one, zero, zero], [zero, c, s], [zero, -s, c]]), 2, 0)
    c, s = np.cos(ankle_pitch + knee), np.sin(ankle_pitch + knee)
    pitch_back = np.moveaxis(np.array([[c, zero, -s], [zero, one, zero], [s, zero, c]]), 2, 0)
    H = np.swapaxes(R, 1, 2) @ roll_back @ pitch_back  # hip yaw, roll, pitch together
    yaw = np.arctan2(-H[:, 0, 1], H[:, 1, 1])
    roll = np.arctan2(H[:, 2, 1], -H[:, 0, 1] * np.sin(yaw) + H[:, 1, 1] * np.cos(yaw))
    pitch = np.arctan2(-H[:, 2, 0], H[:, 2, 2])
    return np.column_stack([yaw, roll, pitch, knee, ankle_pitch, ankle_roll])
