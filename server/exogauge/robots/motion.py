"""What a robot did, without its pose in the world: all that its equations of motion need."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Motion:
    """T samples of J joints and the base link, the latter in its own frame ([Evaluator] 3.2; no base pose or velocity).

    q, dq, ddq: (T, J) [rad, rad/s, rad/s²] (m for prismatic joints).
    acc: (T, 3) [m/s²] proper acceleration of the base link's origin (+9.81 up at rest).
    gyro, gyro_dot: (T, 3) [rad/s, rad/s²] angular velocity and acceleration of the base link.
    """

    q: Array
    dq: Array
    ddq: Array
    acc: Array
    gyro: Array
    gyro_dot: Array

    def __post_init__(self) -> None:
        samples, joints = self.q.shape
        for name in ("dq", "ddq"):
            if getattr(self, name).shape != (samples, joints):
                raise ValueError(f"{name} must be {(samples, joints)}, is {getattr(self, name).shape}")
        for name in ("acc", "gyro", "gyro_dot"):
            if getattr(self, name).shape != (samples, 3):
                raise ValueError(f"{name} must be {(samples, 3)}, is {getattr(self, name).shape}")

    @property
    def samples(self) -> int:
        return int(self.q.shape[0])

    def rows(self, which: slice | NDArray[np.intp] | NDArray[np.bool_]) -> Motion:
        """The same motion at the chosen samples."""
        return Motion(
            self.q[which], self.dq[which], self.ddq[which], self.acc[which], self.gyro[which], self.gyro_dot[which]
        )
