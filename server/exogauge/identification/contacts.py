"""What contact wrenches do to base and axes: each is carried inward along its own bodies only."""

from __future__ import annotations

from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.robots.description import Robot
from exogauge.robots.kinematics import Kinematics

Array = NDArray[np.float64]


@final
class ContactPaths:
    """The bodies between each contact sensor and the base, with the constants of their joints.

    A twentieth of the time of `robots.regressor.contact_effect`, which moves all bodies; the same to rounding.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        kinematics = Kinematics(robot.tree)
        self._turns = np.stack([kinematics.E_0, kinematics.E_c, kinematics.E_s], axis=1).reshape(-1, 9, 3)
        self._axis, self._before = kinematics.axis_in_parent, kinematics.p_before
        self._offset = kinematics.offset_in_body
        self._joints_to_axes = np.linalg.inv(robot.axes_from_joints).T

    def effect(self, q: Array, wrenches: Array) -> Array:
        """(T, rows) generalised force on base axes (floating) and actuator axes: K^T F, axes by C^{-T}.

        q: (T, J). wrenches: (T, S, 6) world on robot, in the frames of the contact sensors.

        Implements [Evaluator] (10), the terms K^T F.
        """
        tree, rows = self.robot.tree, self.robot.rows
        total = np.zeros((rows.axes.stop, len(q)))
        by_joint = np.ascontiguousarray(q.T)
        for index, sensor in enumerate(self.robot.contacts):
            body, pose = tree.frames[sensor.frame]
            if body < 0:
                continue
            wrench = pose.toActionMatrixInverse().T @ wrenches[:, index].T
            wrench = self._carry_inward(body, wrench.reshape(2, 3, -1), by_joint, total[rows.axes])
            if self.robot.floating:
                total[rows.base] += wrench.reshape(6, -1)
        total[rows.axes] = self._joints_to_axes @ total[rows.axes]
        return total.T

    def _carry_inward(self, body: int, wrench: Array, q: Array, joints: Array) -> Array:
        """(2, 3, T) the wrench about the base origin, base frame; adds what it does to joints (J, T) on its way.

        wrench: (2, 3, T) force and moment about the body's origin, in its frame.
        """
        tree = self.robot.tree
        while body >= 0 and tree.dof[body] >= 0:
            joint, f, m = tree.dof[body], wrench[0], wrench[1]
            if self._offset[body].any():
                m = m + _cross(self._offset[body][:, None], f)
            fixed, cosine, sine = self._turns[body].reshape(3, 3, 3)
            c, s = np.cos(q[joint]), np.sin(q[joint])
            f, m = (fixed @ v + c * (cosine @ v) + s * (sine @ v) for v in (f, m))
            r, axis = self._before[body][:, None], self._axis[body]
            if tree.prismatic[body]:
                r = r + axis[:, None] * q[joint]
            joints[joint] += axis @ (f if tree.prismatic[body] else m)
            wrench = np.stack([f, m + _cross(r, f)])
            body = tree.parent[body]
        return wrench


def _cross(r: Array, f: Array) -> Array:
    """(3, T) r x f; r: (3, T) or (3, 1)."""
    return np.stack([r[1] * f[2] - r[2] * f[1], r[2] * f[0] - r[0] * f[2], r[0] * f[1] - r[1] * f[0]])
