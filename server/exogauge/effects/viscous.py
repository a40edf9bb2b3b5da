"""Friction in proportion to speed."""

from __future__ import annotations

from typing import final

from exogauge.effects.effect import Array, JointSignals, Quantity


@final
class Viscous:
    """τ = -k_d θ̇. Implements the first term of [Evaluator] (7)."""

    name = "viscous"
    words = "viscous friction"
    sentence = "Friction grows in proportion to speed."
    coefficient = Quantity("k_d", "N·m·s/rad", low=0.0, words="friction per speed")

    def column(self, signals: JointSignals) -> Array:
        return -signals.velocity


EFFECT = Viscous()
