"""What a force/torque sensor inside the robot reads, as rows of a regressor: the bodies beyond it and nothing else."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.robots.base_parameters import BaseParameters
from exogauge.robots.body_columns import inertia_columns, mass_columns
from exogauge.robots.kinematics import Kinematics, Sweep
from exogauge.robots.motion import Motion
from exogauge.robots.tree import IntArray, RigidTree

Array = NDArray[np.float64]


@final
class CutRows:
    """Six rows, force then moment about the origin of one sensor's frame, in its axes: what moves the bodies beyond."""

    def __init__(self, tree: RigidTree, base: BaseParameters, frame: str) -> None:
        self.tree, self.frame = tree, frame
        body, kind = np.divmod(base.columns, 10)
        beyond = np.isin(body, tree.cuts[frame])
        mass, inertia = (np.flatnonzero(beyond & chosen) for chosen in (kind < 4, kind >= 4))
        self._mass, self._inertia = body[mass] * 4 + kind[mass], body[inertia] * 6 + kind[inertia] - 4
        self.columns: tuple[IntArray, ...] = (mass,) * 3 + (np.concatenate([mass, inertia]),) * 3
        self._kinematics = Kinematics(tree)

    def fill(self, motion: Motion, extra: Sequence[int] = (0,) * 6) -> list[Array]:
        """Per row (T, k_r + extra[r]), Fortran order: regressor columns, then zeros."""
        sweep = self._kinematics.sweep(motion)
        k_1, k_2 = len(self._mass), len(self._inertia)
        columns = np.zeros((6, k_1 + k_2, motion.samples))
        columns[:, :k_1] = mass_columns(self._mass, sweep)
        columns[3:, k_1:] = inertia_columns(self._inertia, sweep)
        blocks = []
        rows = in_sensor(self.tree, self.frame, sweep, columns)
        for row, width, more in zip(rows, (k_1,) * 3 + (k_1 + k_2,) * 3, extra, strict=True):
            block = np.zeros((width + more, motion.samples))
            block[:width] = row[:width]
            blocks.append(block.T)
        return blocks


def in_sensor(tree: RigidTree, frame: str, sweep: Sweep, wrench: Array) -> Array:
    """(6, K, T) wrenches about the base origin in the base frame, about a sensor's origin in its axes."""
    R, p = _pose(tree, frame, sweep, wrench.shape[2])
    force, moment = wrench[:3], wrench[3:] - np.cross(p[:, None], wrench[:3], axis=0)
    return np.concatenate([np.einsum("jit,jkt->ikt", R, each) for each in (force, moment)])


def _pose(tree: RigidTree, frame: str, sweep: Sweep, samples: int) -> tuple[Array, Array]:
    """R_base_sensor (3, 3, T) and its place in the base frame (3, T)."""
    body, T = tree.frames[frame]
    if body < 0:
        return np.repeat(T.rotation[:, :, None], samples, 2), np.repeat(T.translation[:, None], samples, 1)
    R = np.einsum("ijt,jk->ikt", sweep.R[body], T.rotation)
    return R, sweep.p[body] + np.einsum("ijt,j->it", sweep.R[body], T.translation)
