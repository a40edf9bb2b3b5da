"""The base does not stand as upright as it is said to."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.effect import Quantity
from exogauge.effects.places import Array, BaseChange, BaseSignals
from exogauge.effects.shaped import Shape

MOST = 0.2  # [rad]


@final
class BaseTilt:
    """Gravity turned by δ about the base's x and y, δ_z = 0: a_true = exp(δ) a = a + V(δ) (δ × a). Fixed bases only:
    `ImuTilt` is what a floating one has.

    V is taken at the turn that was found so far, so that gravity keeps its size once that is the turn: δ × a alone
    makes it longer by 1/cos |δ|, and every mass, gain and friction wrong with it.

    Where the first joint turns about the vertical, gravity never shows where the mass beyond it lies across the axis.
    On a tilted base it does: first_sin and first_cos are that.
    """

    name = "base_tilt"
    words = "a tilted base"
    place = "base"
    sentence = "The base stands at an angle to gravity that nobody stated."
    coefficients = (
        Quantity("about_x", "rad", -MOST, MOST, words="turn about the base's x axis"),
        Quantity("about_y", "rad", -MOST, MOST, words="turn about the base's y axis"),
        Quantity("first_sin", "N·m", words="torque of gravity at the first joint, with the sine of its angle"),
        Quantity("first_cos", "N·m", words="torque of gravity at the first joint, with the cosine of its angle"),
    )
    shapes: tuple[Shape, ...] = ()
    confounds = ("first moments", "motor_offset", "zero")
    needs = "Turn the whole robot about the vertical between two logs, or turn its first joint by half a turn."
    coordinate = "time"

    def changes(self, signals: BaseSignals, shape: tuple[float, ...]) -> list[BaseChange]:
        still = np.zeros_like(signals.acc)
        if signals.floating:
            return [BaseChange(still, still, still) for _ in self.coefficients]
        V = left_jacobian(signals.turn).T
        turned = [BaseChange(np.cross(axis, signals.acc) @ V, still, still) for axis in np.eye(3)[:2]]
        torques = (np.sin(signals.first_angle), np.cos(signals.first_angle))
        return [*turned, *(BaseChange(still, still, still, torque) for torque in torques)]

    def applies(self, signals: BaseSignals) -> bool:
        return not signals.floating and len(signals.time) > 0


def left_jacobian(delta: Array) -> Array:
    """(3, 3) V of exp(δ) a = a + V (δ × a); I at 0. delta: (3,) [rad]."""
    angle, K = float(np.linalg.norm(delta)), np.cross(np.eye(3), delta)
    if angle < 1e-6:
        return np.asarray(np.eye(3) + 0.5 * K)
    return np.asarray(np.eye(3) + (1.0 - np.cos(angle)) / angle**2 * K + (angle - np.sin(angle)) / angle**3 * K @ K)


EFFECT = BaseTilt()
