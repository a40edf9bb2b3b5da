"""What every model has of a joint: the terms of its torque that are always fitted, one number each."""

from __future__ import annotations

from typing import final

import numpy as np

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


@final
class MotorOffset:
    """τ = τ_o. Implements the second term of [Evaluator] (6)."""

    name = "motor_offset"
    words = "motor offset"
    sentence = "The motor amplifier adds a constant torque."
    coefficient = Quantity("tau_o", "N·m", words="torque that is always there")

    def column(self, signals: JointSignals) -> Array:
        return np.ones_like(signals.drive)


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


@final
class Viscous:
    """τ = -k_d θ̇. Implements the first term of [Evaluator] (7)."""

    name = "viscous"
    words = "viscous friction"
    sentence = "Friction grows in proportion to speed."
    coefficient = Quantity("k_d", "N·m·s/rad", low=0.0, words="friction per speed")

    def column(self, signals: JointSignals) -> Array:
        return -signals.velocity


@final
class Coulomb:
    """τ = -τ_c sgn_ε(θ̇). Implements the second term of [Evaluator] (7)."""

    name = "coulomb"
    words = "Coulomb friction"
    sentence = "Friction of constant size opposes the motion."
    coefficient = Quantity("tau_c", "N·m", low=0.0, words="friction of constant size")

    def column(self, signals: JointSignals) -> Array:
        return -signals.direction


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


EFFECTS = (MotorGain(), MotorOffset(), RotorInertia(), Viscous(), Coulomb(), StaticFriction())
