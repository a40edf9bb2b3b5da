"""The base does not stand as upright as it is said to, or the IMU is not mounted as straight."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.base import BaseChange, BaseSignals
from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Shape

MOST = 0.2  # [rad]


@final
class BaseTilt:
    """Gravity (and what an IMU feels) turned by a small rotation about the base's x and y: a_true = a + δ × a.

    A turn about the vertical changes nothing where the base stands still, and little where it does not.
    """

    name = "base_tilt"
    place = "base"
    sentence = "The base stands at an angle to gravity that nobody stated."
    coefficients = (Quantity("about_x", "rad", -MOST, MOST), Quantity("about_y", "rad", -MOST, MOST))
    shapes: tuple[Shape, ...] = ()
    confounds = ("first moments", "motor_offset", "zero")
    needs = "Turn the whole robot about the vertical between two logs, or turn its first joint by half a turn."
    coordinate = "time"

    def changes(self, signals: BaseSignals, shape: tuple[float, ...]) -> list[BaseChange]:
        return [
            BaseChange(*(np.cross(axis, each) for each in (signals.acc, signals.gyro, signals.gyro_dot)))
            for axis in (np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))
        ]

    def applies(self, signals: BaseSignals) -> bool:
        return len(signals.time) > 0


EFFECT = BaseTilt()
