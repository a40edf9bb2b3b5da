"""Torque that comes and goes with the position."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Array, AxisSignals, Shape

STEP = 0.8  # cycles per range between tried orders: a range of motion tells orders one cycle apart, and hardly less


@final
class TorqueRipple:
    """τ = A_s sin Nθ + A_c cos Nθ, with N cycles per revolution of the joint, not necessarily whole (a gear's is not).

    N is tried from 2 to 28 cycles over the axis' own range: below are gravity and springs; far above, a joint that
    moves at a useful speed makes a ripple faster than encoders can follow. One order at a time: the strongest is found
    first, further ones as findings of their own.
    """

    name = "torque_ripple"
    sentence = "The torque comes and goes with the position, as gear teeth and magnets pass by."
    coefficients = (Quantity("ripple_sin", "N·m"), Quantity("ripple_cos", "N·m"))
    shapes = (
        Shape("cycles", "cycles per range", 1.5, 40.0, tuple(2.0 + STEP * k for k in range(33))),
    )  # fmt: skip
    confounds = ("motor_offset",)
    needs = "Slow steady motion over a wide range of positions, in both directions."
    coordinate = "position"
    claims_at_rest = False

    def columns(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        (cycles,) = shape
        phase = 2.0 * np.pi * cycles / (signals.range or 1.0) * signals.position
        return np.stack([np.sin(phase), np.cos(phase)], axis=1)

    def applies(self, signals: AxisSignals) -> bool:
        return signals.range > 0.0 and bool(np.any(signals.direction != 0.0))


EFFECT = TorqueRipple()
