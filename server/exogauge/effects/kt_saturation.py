"""A motor that gives less per ampere at high current."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Array, AxisSignals, Shape


@final
class KtSaturation:
    """τ = -g u |u/τ|^{p-1}, u the motor's torque k_T i and τ the axis' own rms torque: iron that saturates.

    g is the share of the torque that is lost at u = τ.
    """

    name = "kt_saturation"
    words = "a torque constant that falls with current"
    place = "joint"
    sentence = "At high current the motor gives less torque per ampere."
    coefficients = (
        Quantity("g", "1", low=0.0, high=0.5, words="share of the torque that is lost at the usual torque"),
    )
    shapes = (Shape("power", "1", 1.5, 6.0, (2.0, 3.0, 4.5), words="power of the torque with which the loss grows"),)
    confounds = ("motor_gain",)
    needs = "Loads from low to the highest current: a payload, or fast starts."
    coordinate = "drive"

    def columns(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        u = signals.drive
        return (-u * np.abs(u / (signals.torque_scale or 1.0)) ** (shape[0] - 1.0))[:, None]

    def applies(self, signals: AxisSignals) -> bool:
        return bool(np.any(np.abs(signals.drive) > signals.torque_scale))


EFFECT = KtSaturation()
