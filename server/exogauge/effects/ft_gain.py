"""A force/torque sensor's axis with the wrong gain."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.effect import Quantity
from exogauge.effects.places import Array, SensorSignals
from exogauge.effects.shaped import Shape


@final
class FtGain:
    """w_read = (1 + g) w: one component reads too much or too little, in proportion.

    A gain that all components share cannot be told from a wrong mass of all that the sensor carries.
    """

    name = "ft_gain"
    words = "a wrong gain of the force/torque sensor"
    place = "sensor"
    sentence = "One axis of the force/torque sensor reads too much or too little, in proportion."
    coefficients = (Quantity("gain", "1", -0.5, 0.5, words="share by which too much is read"),)
    shapes: tuple[Shape, ...] = ()
    confounds = ("mass",)
    needs = "Turn the sensor so that gravity pulls along each of its axes, both ways."
    coordinate = "reading"

    def columns(self, signals: SensorSignals, shape: tuple[float, ...]) -> Array:
        return np.asarray(signals.reading[:, None])

    def applies(self, signals: SensorSignals) -> bool:
        return len(signals.time) > 0


EFFECT = FtGain()
