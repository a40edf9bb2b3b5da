"""Friction of a joint that does not move."""

from __future__ import annotations

from typing import final

from exogauge.effects.effect import Array, JointSignals, Quantity


@final
class StaticFriction:
    """τ = -τ_s sgn(r) at rest.

    Implements the third term of [Evaluator] (7) with (8)-(9). Differs from print: the factor is 1 - |sgn θ̇|
    (12 prints 1 - sgn), and r is the full residual, not τ̂ - ĉ_j + F_j (equations.md)."""

    name = "static_friction"
    words = "static friction"
    sentence = "At rest, friction holds the joint against what pushes it."
    coefficient = Quantity("tau_s", "N·m", low=0.0, words="most that holds at rest")

    def column(self, signals: JointSignals) -> Array:
        return -signals.stick


EFFECT = StaticFriction()
