"""How the base may stand or move otherwise than it is said to."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol, final

import numpy as np
from numpy.typing import NDArray

from exogauge.effects.shaped import MissingEffect

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class BaseSignals:
    """T samples of the base link, in its frame: (T, 3) proper acceleration [m/s²], angular velocity [rad/s] and
    acceleration [rad/s²], and their rates. time: (T,) [s]. floating: measured by an IMU; else it stands still.
    first_angle: (T,) [rad] of the first joint. imu_at: (3,) [m] where the IMU is. feet_feel: every contact sensor
    measures forces and moments along all axes (what nobody measured is logged as a constant)."""

    time: Array
    acc: Array
    gyro: Array
    gyro_dot: Array
    acc_rate: Array
    gyro_rate: Array
    gyro_dot_rate: Array
    floating: bool
    first_angle: Array
    imu_at: Array = field(default_factory=lambda: np.zeros(3))
    feet_feel: bool = False


@final
@dataclass(frozen=True)
class BaseChange:
    """(T, 3) each: how the base's motion differs per unit of a coefficient.

    first_torque: (T,) [N·m] what the first joint has to give beside that.
    """

    acc: Array
    gyro: Array
    gyro_dot: Array
    first_torque: Array | None = None


class BaseEffect(MissingEffect, Protocol):
    """Of the base. place is `base`; coordinate: `time`."""

    def changes(self, signals: BaseSignals, shape: tuple[float, ...]) -> list[BaseChange]:
        """One for each coefficient: the true motion is the stated one plus these."""
        ...

    def applies(self, signals: BaseSignals) -> bool:
        """Whether the log holds what the effect needs."""
        ...
