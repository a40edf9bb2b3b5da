"""Friction that does not grow in proportion to speed."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Array, AxisSignals, Shape


@final
class NonlinearViscous:
    """τ = -τ_n |θ̇/v|^p sgn θ̇ with v the axis' own rms velocity: concave for p < 1, progressive for p > 1.

    It comes on top of viscous friction k_d θ̇, so p = 1 says nothing and is not on the grid.
    """

    name = "nonlinear_viscous"
    place = "joint"
    sentence = "Friction grows with speed along a curve, not along a straight line."
    coefficients = (Quantity("tau_n", "N·m", low=0.0),)
    shapes = (Shape("power", "1", 0.25, 3.0, (0.33, 0.5, 0.7, 1.5, 2.0, 3.0)),)
    confounds = ("viscous", "coulomb")
    needs = "Steady motion at many speeds from slow to the fastest."
    coordinate = "velocity"

    def columns(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        (power,) = shape
        x = np.abs(signals.velocity) / (signals.speed_scale or 1.0)
        return (-(x**power) * signals.direction)[:, None]

    def applies(self, signals: AxisSignals) -> bool:
        return bool(np.any(signals.direction != 0.0))


EFFECT = NonlinearViscous()
