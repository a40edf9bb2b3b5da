"""A gear that gives way like a spring."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.effect import Quantity
from exogauge.effects.rates import second_rate_of_change
from exogauge.effects.shaped import Array, AxisSignals, Shape

SOFTEST = (2.0 * np.pi * 2.0) ** -2  # [s²] the link on its spring at 2 Hz; a softer joint is no robot's
SOFT_HZ = 5.0  # a soft joint's resonance; where it would not show, none does
LEAST_SHARE = 0.01  # of the rms torque


@final
class Elasticity:
    """τ = c τ̈_load, encoder at the motor: θ_link = θ - τ_load/k_e, so the link's acceleration lacks τ̈_load/k_e, and
    c = J/k_e = 1/ω². Gravity's part of the same goes with the load and is the motor gain's.

    With an encoder at the link the rotor turns by τ_load/k_e more, which is the same column with c < 0. That is not
    looked for: noise of the positions makes c < 0 by itself.

    It cannot be told where the motion is slow against ω (`applies` says so), nor well from rotor inertia where the
    load is mostly gravity, whose second derivative goes with the acceleration.
    """

    name = "elasticity"
    place = "joint"
    sentence = "The gear gives way like a spring, so the link does not move as the motor's encoder says."
    coefficients = (Quantity("c", "s²", low=0.0, high=SOFTEST),)
    shapes: tuple[Shape, ...] = ()
    confounds = ("rotor_inertia", "motor_gain")
    needs = "Fast motion with quick starts and stops, or a second encoder at the link."
    coordinate = "acceleration"

    def columns(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        return second_rate_of_change(signals.load, signals.time)[:, None]

    def applies(self, signals: AxisSignals) -> bool:
        if len(signals.time) < 3 or not np.any(signals.direction != 0.0):
            return False
        jolt = float(np.sqrt(np.mean(second_rate_of_change(signals.load, signals.time) ** 2)))
        return jolt / (2.0 * np.pi * SOFT_HZ) ** 2 > LEAST_SHARE * signals.torque_scale


EFFECT = Elasticity()
