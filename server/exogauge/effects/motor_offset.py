"""A constant torque from the motor amplifier."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.effect import Array, JointSignals, Quantity


@final
class MotorOffset:
    """τ = τ_o. Implements the second term of [Evaluator] (6)."""

    name = "motor_offset"
    words = "motor offset"
    sentence = "The motor amplifier adds a constant torque."
    coefficient = Quantity("tau_o", "N·m", words="torque that is always there")

    def column(self, signals: JointSignals) -> Array:
        return np.ones_like(signals.drive)


EFFECT = MotorOffset()
