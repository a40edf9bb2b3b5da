"""The base's IMU is stamped later than everything else."""

from __future__ import annotations

from typing import final

from exogauge.effects.effect import Quantity
from exogauge.effects.places import BaseChange, BaseSignals
from exogauge.effects.shaped import Shape


@final
class ImuDelay:
    """What is logged at t was felt at t - delay: a_true(t) = a(t + delay) = a + delay da/dt, to first order."""

    name = "imu_delay"
    words = "a delay of the IMU"
    place = "base"
    sentence = "The readings of the base's IMU are stamped later than they were taken."
    coefficients = (Quantity("delay", "s", -0.2, 0.2, words="time by which readings are stamped late"),)
    shapes: tuple[Shape, ...] = ()
    confounds = ("viscous",)
    needs = "A quick motion of the whole base, such as a push."
    coordinate = "time"

    def changes(self, signals: BaseSignals, shape: tuple[float, ...]) -> list[BaseChange]:
        return [BaseChange(signals.acc_rate, signals.gyro_rate, signals.gyro_dot_rate)]

    def applies(self, signals: BaseSignals) -> bool:
        return signals.floating and len(signals.time) > 0


EFFECT = ImuDelay()
