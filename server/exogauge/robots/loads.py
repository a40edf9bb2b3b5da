"""What bodies with given parameters ask of base, axes and sensors, for many samples at once: Y φ without Y."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.robots.kinematics import Kinematics
from exogauge.robots.motion import Motion
from exogauge.robots.parameters import BaseParameters
from exogauge.robots.row_blocks import AXES, signals_of, tree_arrays
from exogauge.robots.tree import RigidTree

Array = NDArray[np.float64]


@final
class BodyLoads:
    """By the same sweep as `RowBlocks`, of whose columns only the sum is wanted. Threads may share it."""

    def __init__(
        self, tree: RigidTree, base: BaseParameters, axes_from_joints: Array, sensor_frames: Sequence[str]
    ) -> None:
        self._base, self._floating, self._joints = base, tree.floating, len(tree.joints)
        self._bodies, self._to_axes = len(tree.bodies), np.asarray(np.linalg.inv(axes_from_joints).T)  # C⁻ᵀ
        self._mixed = not np.array_equal(self._to_axes, np.eye(self._joints))
        self._tree = tree_arrays(Kinematics(tree))
        places = [tree.frames[frame] for frame in sensor_frames]
        self._sensors: tuple[NDArray[np.bool_], NDArray[np.int64], Array, Array] = (
            np.array([np.isin(np.arange(self._bodies), tree.cuts[frame]) for frame in sensor_frames], dtype=np.bool_)
            .reshape(-1, self._bodies),
            np.array([body for body, _ in places], dtype=np.int64),
            np.array([pose.rotation for _, pose in places]).reshape(-1, 9),
            np.array([pose.translation for _, pose in places]).reshape(-1, 3),
        )  # fmt: skip

    def of(self, motion: Motion, phi: Array) -> Array:
        """(L, rows, T) of each of L parameter sets: six base rows when floating, actuator axes, six for each sensor.

        phi: (B, L) base parameters.
        """
        from exogauge.loops.loads import fill_loads

        standard = np.zeros((10 * self._bodies, phi.shape[1]))
        standard[self._base.columns] = phi
        sets = np.ascontiguousarray(standard.T).reshape(-1, self._bodies, 10)
        live: NDArray[np.bool_] = np.any(sets != 0.0, axis=2)
        out = np.empty((len(sets), 6 + self._joints + 6 * len(self._sensors[0]), motion.samples))
        if motion.samples:
            signals, base = signals_of(motion)
            fill_loads(*self._tree, sets, live, *self._sensors, signals, base, AXES, out)
        if self._mixed:
            joints = out[:, 6 : 6 + self._joints]
            joints[:] = self._to_axes @ joints
        return out if self._floating else out[:, 6:]
