"""An offset of the torque that changes slowly."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Array, AxisSignals, Shape


@final
class TorqueOffsetDrift:
    """τ = r (t - t̄) + a (e^{-t/t_d} - mean), t from the log's start and both of zero mean over the log.

    An amplifier or a torque sensor that warms up after it was zeroed: each log drifts alike from its start.
    """

    name = "torque_offset_drift"
    words = "a drifting torque offset"
    place = "joint"
    sentence = "The offset of the torque changes slowly while the robot runs."
    coefficients = (
        Quantity("ramp", "N·m/s", words="drift per second that goes on"),
        Quantity("settling", "N·m", words="drift that comes to an end"),
    )
    departing = (Quantity("slow_settling", "N·m"), Quantity("slowest_settling", "N·m"))
    shapes = (Shape("t_d", "s", 2.0, 300.0, (5.0, 20.0, 80.0), words="time in which it does"),)
    confounds = ("motor_offset",)
    needs = "The same motion again after minutes, and a moment in a known posture at the start and the end."
    coordinate = "time"

    def columns(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        if len(signals.time) == 0:
            return np.zeros((0, 2))
        both = np.stack([signals.time, np.exp(-signals.time / shape[0])], axis=1)
        return np.asarray(both - both.mean(axis=0))

    def departures(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        """(T, 2) the same with three and nine times the time constant."""
        return np.hstack([self.columns(signals, (slower * shape[0],))[:, 1:] for slower in (3.0, 9.0)])

    def applies(self, signals: AxisSignals) -> bool:
        least_duration = 5.0  # [s]
        return len(signals.time) > 0 and float(np.ptp(signals.time)) >= least_duration


EFFECT = TorqueOffsetDrift()
