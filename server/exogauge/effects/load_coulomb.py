"""Friction that grows with the load."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Array, AxisSignals, Shape


@final
class LoadCoulomb:
    """τ = -μ |τ_load| sgn θ̇: the teeth of a gear press and rub in proportion to the torque that they pass on."""

    name = "load_coulomb"
    words = "load-dependent friction"
    place = "joint"
    sentence = "Friction grows with the torque that the joint has to carry."
    coefficients = (Quantity("mu", "1", low=0.0, high=1.0, words="friction per torque that the joint carries"),)
    shapes: tuple[Shape, ...] = ()
    confounds = ("coulomb", "motor_gain", "motor_offset")
    needs = "The same motion under several loads: other postures, or a payload in the hand."
    coordinate = "load"
    along_motion = True

    def columns(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        return (-np.abs(signals.load) * signals.direction)[:, None]

    def applies(self, signals: AxisSignals) -> bool:
        least_spread = 0.1  # of |load| in motion, in rms torques: with one load it is Coulomb friction and nothing else
        load = np.abs(signals.load[signals.direction != 0.0])
        return load.size > 0 and float(np.ptp(load)) > least_spread * signals.torque_scale


EFFECT = LoadCoulomb()
