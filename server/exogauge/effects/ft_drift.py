"""The zero of a force/torque sensor moves."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.effect import Quantity
from exogauge.effects.order import one_log, present
from exogauge.effects.places import Array, SensorSignals
from exogauge.effects.shaped import Shape


@final
class FtDrift:
    """z(t) = r t + a (1 - e^{-t/t_d}), t from a log's start, where the zero is what it is elsewhere.

    A strain gauge that warms up after it was zeroed: in every log (`log` -1), or in one, by its number in the order of
    the study.
    """

    name = "ft_drift"
    words = "a drifting zero of the force/torque sensor"
    place = "sensor"
    sentence = "The zero of one axis of the force/torque sensor moves while the robot runs."
    coefficients = (
        Quantity("ramp", "reading/s", words="drift per second that goes on"),
        Quantity("settling", "reading", words="drift that comes to an end"),
    )
    departing = (Quantity("slow_settling", "reading"), Quantity("slowest_settling", "reading"))
    shapes = (Shape("t_d", "s", 2.0, 300.0, (5.0, 20.0, 80.0), words="time in which it does"), one_log())
    confounds = ("zero",)
    needs = "The same posture at the start and at the end of a log, and after minutes."
    coordinate = "time"
    common_cause = True

    def columns(self, signals: SensorSignals, shape: tuple[float, ...]) -> Array:
        t_d = shape[0]
        here = float(present(self.shapes, shape, signals.number))
        return here * np.stack([signals.time, 1.0 - np.exp(-signals.time / t_d)], axis=1)

    def departures(self, signals: SensorSignals, shape: tuple[float, ...]) -> Array:
        """(T, 2) the same with three and nine times the time constant."""
        t_d, log = shape
        return np.hstack([self.columns(signals, (slower * t_d, log))[:, 1:] for slower in (3.0, 9.0)])

    def applies(self, signals: SensorSignals) -> bool:
        least_duration = 5.0  # [s]
        return len(signals.time) > 0 and float(np.ptp(signals.time)) >= least_duration


EFFECT = FtDrift()
