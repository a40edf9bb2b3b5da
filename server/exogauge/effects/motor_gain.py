"""The motor turns current into torque."""

from __future__ import annotations

from typing import final

from exogauge.effects.effect import Array, JointSignals, Quantity


@final
class MotorGain:
    """τ = k_T u. Implements the first term of [Evaluator] (6).

    Differs from print: k_T holds the gear ratio once; the text after (6) says squared.
    """

    name = "motor_gain"
    words = "motor gain"
    sentence = "The motor turns current into torque in proportion."
    coefficient = Quantity("k_T", "N·m/A", low=0.0, words="torque per ampere")

    def column(self, signals: JointSignals) -> Array:
        return signals.drive


EFFECT = MotorGain()
