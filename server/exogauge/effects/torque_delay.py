"""A torque that comes later than its log says, or is logged later than it comes.

Rates of change of what a shaped effect sees, zero where a log is too short to have any.
"""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Array, AxisSignals, Shape
from exogauge.logs.derivatives import differentiate, differentiate_twice


@final
class TorqueDelay:
    """τ = -δ u̇, u the motor's torque: u(t - δ) ≈ u - δ u̇, in error by at most ½ δ² |ü|. Also a first-order lag.

    δ > 0: the torque acts later than it is logged (an amplifier's lag). δ < 0: it is logged later than it acts (a slow
    or filtered torque sensor). The motor's torque and not the load, because friction is delayed with it.
    """

    name = "torque_delay"
    words = "a delay of the torque"
    place = "joint"
    sentence = "The torque acts later than its log says, or is logged later than it acts."
    coefficients = (Quantity("delta", "s", low=-0.1, high=0.1, words="time by which the torque acts late"),)
    shapes: tuple[Shape, ...] = ()
    departing = (Quantity("delta_squared", "s²"), Quantity("delta_cubed", "s³"))
    confounds = ("viscous",)
    needs = "Quick changes of the load, and reversals at speed."
    coordinate = "acceleration"
    common_cause = True

    def columns(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        return -rate_of_change(signals.drive, signals.time)[:, None]

    def departures(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        """(T, 2) ½ ü and -⅙ u⃛, the next terms of a delay or a lag that is long for what the motor does in it."""
        twice = second_rate_of_change(signals.drive, signals.time)
        return np.stack([0.5 * twice, -rate_of_change(twice, signals.time) / 6.0], axis=1)

    def applies(self, signals: AxisSignals) -> bool:
        known = len(signals.time) > 2  # a rate of change takes three samples
        return known and bool(np.any(signals.direction != 0.0)) and signals.torque_scale > 0.0


EFFECT = TorqueDelay()


def rate_of_change(values: Array, time: Array) -> Array:
    """(T,) d/dt of values (T,), evenly sampled at time (T,) [s]."""
    return differentiate(values, _rate_hz(time)) if len(time) > 2 else 0.0 * values


def second_rate_of_change(values: Array, time: Array) -> Array:
    """(T,) d²/dt² of values (T,), evenly sampled at time (T,) [s]."""
    return differentiate_twice(values, _rate_hz(time)) if len(time) > 2 else 0.0 * values


def _rate_hz(time: Array) -> float:
    return (len(time) - 1) / float(time[-1] - time[0])
