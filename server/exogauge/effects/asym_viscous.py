"""Friction that grows faster with speed in one direction than in the other."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Array, AxisSignals, Shape


@final
class AsymViscous:
    """τ = -d_a |θ̇|: viscous friction is k_d + d_a forwards and k_d - d_a backwards.

    Coulomb friction that depends on the direction is no part of it: its two halves are a mean and a constant, and the
    constant is the motor's offset, (τ₊+τ₋)/2 sgn θ̇ + (τ₊-τ₋)/2.
    """

    name = "asym_viscous"
    words = "direction-dependent viscous friction"
    place = "joint"
    sentence = "Viscous friction is larger in one direction of motion than in the other."
    coefficients = (
        Quantity(
            "d_a", "N·m·s/rad", words="viscous friction that is more in the positive direction, and less in the other"
        ),
    )
    shapes: tuple[Shape, ...] = ()
    confounds = ("viscous", "motor_offset")
    needs = "Motion at several speeds in both directions through the same postures."
    coordinate = "velocity"

    def columns(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        return -np.abs(signals.velocity)[:, None]

    def applies(self, signals: AxisSignals) -> bool:
        return bool(np.any(signals.direction > 0.0) and np.any(signals.direction < 0.0))


EFFECT = AsymViscous()
