"""What contact wrenches do to base and axes: each is carried inward along its own bodies only."""

from __future__ import annotations

from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.robots.description import Robot
from exogauge.robots.kinematics import Kinematics

Array = NDArray[np.float64]
# As `loops.contact_path` takes it: to the first body, turns, axes, before, offsets, which slide, columns of q.
Path = tuple[Array, Array, Array, Array, Array, NDArray[np.bool_], NDArray[np.int64]]


@final
class ContactPaths:
    """The bodies between each contact sensor and the base, with the constants of their joints.

    `robots.regressor.contact_effect` moves all bodies; this is the same to rounding.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        tree, kinematics = robot.tree, Kinematics(robot.tree)
        turns = np.stack([kinematics.E_0, kinematics.E_c, kinematics.E_s], axis=1)
        self._paths: list[Path | None] = []  # None: the sensor stands on what does not move
        for sensor in robot.contacts:
            body, pose = tree.frames[sensor.frame]
            if body < 0:
                self._paths.append(None)
                continue
            bodies: list[int] = []
            while body >= 0 and tree.dof[body] >= 0:
                bodies.append(body)
                body = tree.parent[body]
            along = np.array(bodies, dtype=np.int64)
            self._paths.append(
                (
                    np.ascontiguousarray(pose.toActionMatrixInverse().T),
                    turns[along],
                    kinematics.axis_in_parent[along],
                    kinematics.p_before[along],
                    kinematics.offset_in_body[along],
                    tree.prismatic[along],
                    tree.dof[along],
                )
            )
        self._axes_from_joints = np.linalg.inv(robot.axes_from_joints)

    def effect(self, q: Array, wrenches: Array) -> Array:
        """(T, rows) generalised force on base axes (floating) and actuator axes: K^T F, axes by C^{-T}.

        q: (T, J). wrenches: (T, S, 6) world on robot, in the frames of the contact sensors.

        Implements [Evaluator] (10), the terms K^T F.
        """
        total = np.zeros((len(q), 1, self.robot.rows.axes.stop))
        for sensor in range(len(self.robot.contacts)):
            self._carry_inward(sensor, q, wrenches[:, sensor, None], total)
        return self._on_axes(total)[:, 0]

    def of_components(self, q: Array, sensor: int) -> Array:
        """(T, 6, rows) the same of one newton, and one newton metre, of each component at a sensor: K."""
        units = np.broadcast_to(np.eye(6), (len(q), 6, 6))
        total = np.zeros((len(q), 6, self.robot.rows.axes.stop))
        self._carry_inward(sensor, q, units, total)
        return self._on_axes(total)

    def _carry_inward(self, sensor: int, q: Array, wrenches: Array, total: Array) -> None:
        """Adds to total (T, W, base axes and joints) what (T, W, 6) wrenches at a sensor do."""
        from exogauge.loops.contact_path import carry_inward

        path = self._paths[sensor]
        if path is not None:
            carried = np.ascontiguousarray(wrenches, dtype=np.float64)
            carry_inward(*path, np.ascontiguousarray(q), carried, self.robot.floating, total)

    def _on_axes(self, total: Array) -> Array:
        axes = self.robot.rows.axes
        if self.robot.coupled:
            total[..., axes] = total[..., axes] @ self._axes_from_joints
        return total
