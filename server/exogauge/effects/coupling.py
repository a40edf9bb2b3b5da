"""A motor that turns with two joints: its friction and its rotor act on both."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.effect import Quantity
from exogauge.effects.places import Array, PairSignals
from exogauge.effects.shaped import Shape


@final
class Coupling:
    """τ = -(τ_w sgn θ̇_w + d_w θ̇_w + J_w θ̈_w) on the joint and r τ on the one before it, θ_w = θ + r θ_before.

    As in a wrist whose last motor drives through the joint before: θ_w is that motor's angle, as an angle of its joint.
    Friction of each joint's own is in the model beside it. What is viscous alone, or inertia alone, shows the product
    of r and the coefficient only: [[d, r d], [r d, r² d]] and each joint's own friction differ in nothing else.
    """

    name = "coupling"
    words = "coupling of the motor axes"
    place = "pair"
    sentence = "Its motor turns with the joint before it too, so that friction or inertia of the drive acts on both."
    coefficients = (
        Quantity("coupled_coulomb", "N·m", low=0.0, words="Coulomb friction of what turns with both joints"),
        Quantity("coupled_viscous", "N·m·s/rad", low=0.0, words="viscous friction of what turns with both joints"),
        Quantity("coupled_inertia", "kg·m²", low=0.0, words="inertia of what turns with both joints"),
    )
    shapes = (
        Shape(
            "ratio",
            "1",
            -3.0,
            3.0,
            (-2.0, -1.0, -0.5, -0.25, 0.25, 0.5, 1.0, 2.0),
            words="turns per turn of the joint before, in turns of its own joint",
        ),
    )
    confounds = ("coulomb", "viscous", "rotor_inertia")
    needs = "Both joints at once, turning the same way and opposite ways, slow and fast."
    coordinate = "motor_velocity"

    def columns(self, signals: PairSignals, shape: tuple[float, ...]) -> Array:
        (ratio,) = shape
        velocity = signals.motor_velocity(shape)
        acceleration = signals.own.acceleration + ratio * signals.other.acceleration
        direction = np.where(_moves(signals), np.sign(velocity), 0.0)
        on_own = -np.stack([direction, velocity, acceleration], axis=1)
        return np.stack([on_own, ratio * on_own], axis=2)

    def applies(self, signals: PairSignals) -> bool:
        """Both have to move at once, at some moments the same way and at others opposite ways."""
        together = signals.own.direction * signals.other.direction
        return bool(np.any(together > 0.0) and np.any(together < 0.0))


def _moves(signals: PairSignals) -> Array:
    """(T,) bool: a velocity while both rest is noise."""
    return np.asarray((signals.own.direction != 0.0) | (signals.other.direction != 0.0))


EFFECT = Coupling()
