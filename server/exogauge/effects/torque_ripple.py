"""Torque that comes and goes with the position."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Array, AxisSignals, Shape


@final
class TorqueRipple:
    """τ = A_s sin Nθ + A_c cos Nθ, N in cycles per revolution of the joint, not necessarily whole (a gear's is not).

    N is resolved to about one cycle over the range of motion, 2π / range.
    """

    name = "torque_ripple"
    sentence = "The torque comes and goes with the position, as gear teeth and magnets pass by."
    coefficients = (Quantity("ripple_sin", "N·m"), Quantity("ripple_cos", "N·m"))
    shapes = (Shape("cycles_per_revolution", "1/rev", 4.0, 400.0, tuple(float(n) for n in range(6, 126, 5))),)
    confounds = ("motor_offset",)
    needs = "Slow steady motion over a wide range of positions, in both directions."
    coordinate = "position"
    claims_at_rest = False

    def columns(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        (N,) = shape
        theta = signals.position
        return np.stack([np.sin(N * theta), np.cos(N * theta)], axis=1)

    def applies(self, signals: AxisSignals) -> bool:
        return signals.range > 2.0 * np.pi / self.shapes[0].high and bool(np.any(signals.direction != 0.0))


EFFECT = TorqueRipple()
