"""A foot's force/torque sensor is mounted at another angle than stated."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.base_tilt import MOST
from exogauge.effects.effect import Quantity
from exogauge.effects.places import Array, SensorSignals
from exogauge.effects.shaped import Shape


@final
class FtTilt:
    """f_read = R f, n_read = R n with a small rotation R = 1 + δ×: what is read too much is δ × f and δ × n.

    A force that stands on the sensor shows across; a turn about that force hardly shows. One foot tells it from the
    base's IMU, which all feet would share, as the load goes from one to the other; a single one cannot be told from it.
    """

    name = "ft_tilt"
    words = "a tilted force/torque sensor"
    place = "whole_sensor"
    sentence = "The force/torque sensor under a foot is mounted at an angle that nobody stated."
    coefficients = (
        Quantity("about_x", "rad", -MOST, MOST, words="turn about the sensor's x axis"),
        Quantity("about_y", "rad", -MOST, MOST, words="turn about the sensor's y axis"),
        Quantity("about_z", "rad", -MOST, MOST, words="turn about the sensor's z axis"),
    )
    shapes: tuple[Shape, ...] = ()
    confounds = ("zero", "ft_crosstalk", "leg encoders")
    needs = "Load one foot after the other, and lean over both ways."
    coordinate = "time"

    def columns(self, signals: SensorSignals, shape: tuple[float, ...]) -> Array:
        force, moment = signals.expected[:, :3], signals.expected[:, 3:]
        return np.stack([np.hstack([np.cross(axis, force), np.cross(axis, moment)]) for axis in np.eye(3)], axis=1)

    def applies(self, signals: SensorSignals) -> bool:
        return signals.contacts > 1 and len(signals.time) > 0


EFFECT = FtTilt()
