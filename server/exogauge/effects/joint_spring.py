"""A harness that pulls the joint back."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Array, AxisSignals, Shape

FROM = (-0.3, -0.15, 0.0, 0.15, 0.3)  # ranges of the joint away from θ_h, where a curve of its own begins to bend


@final
class JointSpring:
    """τ = -k_h (θ - θ_h) - k_3 (θ - θ_h)³: cables, hoses and covers that turn with the joint.

    θ_h is the same in every log. It shows only in the cubic part: with k_3 = 0 it is a constant torque, which is the
    motor's offset. It acts between two links, so the base rows do not see it.
    """

    name = "joint_spring"
    words = "a spring on the joint"
    place = "joint"
    sentence = "A harness or cover pulls the joint back, more the further it turns."
    coefficients = (
        Quantity("k_h", "N·m/rad", low=0.0, words="stiffness"),
        Quantity("k_3", "N·m/rad³", low=0.0, words="stiffening, with the cube of the angle"),
    )
    shapes = (Shape("theta_h", "rad", -3.0, 3.0, (-1.5, 0.0, 1.5), words="angle at which the cubic part is at rest"),)
    departing = tuple(Quantity(f"k_2_{side}{k}", "N·m/rad²") for side in "+-" for k in range(1, len(FROM) + 1))
    confounds = ("motor_offset",)
    needs = "Slow motion through the whole range of the joint, with the links beyond it in several postures."
    coordinate = "position"

    def columns(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        x = signals.position - shape[0]
        return np.stack([-x, -(x**3)], axis=1)

    def departures(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        """(T, 10) pulls that grow as the square of the way beyond each of the places `FROM`, to either side."""
        x = (signals.position - shape[0])[:, None] - signals.range * np.array(FROM)
        return np.concatenate([-(np.maximum(x, 0.0) ** 2), np.minimum(x, 0.0) ** 2], axis=1)

    def applies(self, signals: AxisSignals) -> bool:
        return len(signals.time) > 0 and signals.range > 0.0


EFFECT = JointSpring()
