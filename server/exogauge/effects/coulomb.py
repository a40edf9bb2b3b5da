"""Friction of constant size against the motion."""

from __future__ import annotations

from typing import final

from exogauge.effects.effect import Array, JointSignals, Quantity


@final
class Coulomb:
    """τ = -τ_c sgn_ε(θ̇). Implements the second term of [Evaluator] (7)."""

    name = "coulomb"
    words = "Coulomb friction"
    sentence = "Friction of constant size opposes the motion."
    coefficient = Quantity("tau_c", "N·m", low=0.0, words="friction of constant size")

    def column(self, signals: JointSignals) -> Array:
        return -signals.direction


EFFECT = Coulomb()
