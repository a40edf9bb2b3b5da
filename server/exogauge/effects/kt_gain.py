"""A motor that gives another torque than the one that its drive logs."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Array, AxisSignals, Shape


@final
class KtGain:
    """τ = share u, u the torque that the motor gives: what of it is not logged. Logged is (1 - share) u.

    Where currents are logged the baseline's k_T takes this place; whether it contradicts what is stated, is asked by
    `detect/nominal`."""

    name = "kt_gain"
    words = "a wrong torque constant"
    place = "joint"
    sentence = "The motor gives another torque than is logged, by one factor."
    coefficients = (Quantity("share", "1", low=-0.5, high=0.5, words="share of the motor's torque that is not logged"),)
    shapes = tuple[Shape, ...]()
    confounds = ("motor_gain",)
    needs = "Other joints that carry the same links under load, or a known load."
    coordinate = "drive"
    of_logged_torque = True

    def columns(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        return signals.drive[:, None].copy()

    def applies(self, signals: AxisSignals) -> bool:
        return bool(np.any(signals.direction != 0.0))


EFFECT = KtGain()
