"""A robot's motion over time, as it is planned, checked and handed out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Trajectory:
    """time: (T,) [s]. q, dq, ddq: (T, B + J) in the coordinates of `MotionRobot.model`: B = 6 of a floating base (its
    place x, y, z [m] in the world; its turns yaw, roll, pitch [rad] about z, then x, then y), 0 of a fixed one; then
    the joints [rad or m], in the order of `joints`."""

    time: Array
    q: Array
    dq: Array
    ddq: Array
    joints: tuple[str, ...]

    @property
    def base(self) -> int:
        """B"""
        return int(self.q.shape[1]) - len(self.joints)
