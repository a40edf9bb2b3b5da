"""The zero of a foot's force/torque sensor is another one than was taken off."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.effect import Quantity
from exogauge.effects.order import one_log, present
from exogauge.effects.places import Array, SensorSignals


@final
class FtZero:
    """w_read = w + z, in every log (`log` -1) or in one. Of a sensor that carries bodies every model has it."""

    name = "ft_zero"
    words = "a wrong zero of the force/torque sensor"
    place = "sensor"
    sentence = "One axis of the force/torque sensor under a foot reads a constant that was not taken off."
    coefficients = (Quantity("zero", "reading", words="what is read too much"),)
    shapes = (one_log(),)
    confounds = ("mass", "first moments", "base_tilt")
    needs = "Lift the foot off the ground, or let the robot hang, and take the zero again."
    coordinate = "time"

    def columns(self, signals: SensorSignals, shape: tuple[float, ...]) -> Array:
        here = float(signals.contacts > 0 and present(self.shapes, shape, signals.number))
        return np.full((len(signals.time), 1), here)

    def applies(self, signals: SensorSignals) -> bool:
        return signals.contacts > 0 and len(signals.time) > 0


EFFECT = FtZero()
