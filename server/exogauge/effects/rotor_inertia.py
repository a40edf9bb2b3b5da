"""The inertia of the rotor, seen through the gear."""

from __future__ import annotations

from typing import final

from exogauge.effects.effect import Array, JointSignals, Quantity


@final
class RotorInertia:
    """τ = -J_r θ̈ with J_r = N² J_m.

    Not in [Evaluator]; large on geared joints, and the links' inertia cannot absorb it.
    """

    name = "rotor_inertia"
    words = "rotor inertia"
    sentence = "The rotor's inertia, seen through the gear, resists acceleration."
    coefficient = Quantity("J_r", "kg·m²", low=0.0, words="inertia of the rotor, seen through the gear")

    def column(self, signals: JointSignals) -> Array:
        return -signals.acceleration


EFFECT = RotorInertia()
