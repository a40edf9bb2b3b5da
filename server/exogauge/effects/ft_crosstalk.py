"""One axis of a force/torque sensor leaks into another."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.effect import Quantity
from exogauge.effects.places import Array, SensorSignals
from exogauge.effects.shaped import Shape


@final
class FtCrosstalk:
    """w_read = w + c w_other; other: 0..5, the component that leaks (forces before moments).

    A force leaks into a moment in N·m per N, that is by a length, as if the frame stood elsewhere.
    """

    name = "ft_crosstalk"
    words = "crosstalk of the force/torque sensor"
    place = "sensor"
    sentence = "One axis of the force/torque sensor reads part of what another one feels."
    coefficients = (
        Quantity("leak", "reading/reading", -0.5, 0.5, words="share of the other component that is read here"),
    )
    shapes = (
        Shape(
            "other",
            "1",
            0.0,
            5.0,
            (0.0, 1.0, 2.0, 3.0, 4.0, 5.0),
            choice=True,
            words="component that leaks, 0 (fx) to 5 (mz)",
        ),
    )
    confounds = ("first moments", "the sensor's frame")
    needs = "Load one axis of the sensor at a time."
    coordinate = "time"

    def columns(self, signals: SensorSignals, shape: tuple[float, ...]) -> Array:
        other = round(shape[0])
        if other == signals.component:
            return np.zeros((len(signals.time), 1))
        return np.asarray(signals.expected[:, other, None])

    def applies(self, signals: SensorSignals) -> bool:
        return len(signals.time) > 0


EFFECT = FtCrosstalk()
