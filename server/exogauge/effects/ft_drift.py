"""The zero of a force/torque sensor moves."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.effect import Quantity
from exogauge.effects.sensor import Array, SensorSignals
from exogauge.effects.shaped import Shape

LEAST_DURATION = 5.0  # [s]


@final
class FtDrift:
    """z(t) = r (t - t̄) + a (e^{-t/t_d} - mean), t from each log's start; what does not move is the sensor's zero.

    A strain gauge that warms up after it was zeroed.
    """

    name = "ft_drift"
    place = "sensor"
    sentence = "The zero of one axis of the force/torque sensor moves while the robot runs."
    coefficients = (Quantity("ramp", "reading/s"), Quantity("settling", "reading"))
    shapes = (Shape("t_d", "s", 2.0, 300.0, (5.0, 20.0, 80.0)),)
    confounds = ("zero",)
    needs = "The same posture at the start and at the end of a log, and after minutes."
    coordinate = "time"

    def columns(self, signals: SensorSignals, shape: tuple[float, ...]) -> Array:
        both = np.stack([signals.time, np.exp(-signals.time / shape[0])], axis=1)
        return np.asarray(both - both.mean(axis=0))

    def applies(self, signals: SensorSignals) -> bool:
        return len(signals.time) > 0 and float(np.ptp(signals.time)) >= LEAST_DURATION


EFFECT = FtDrift()
