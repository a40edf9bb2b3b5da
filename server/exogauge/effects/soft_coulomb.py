"""Coulomb friction that turns round over a span of speeds instead of at once."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Array, AxisSignals, Shape


@final
class SoftCoulomb:
    """τ = τ_c (1 - tanh(|θ̇| / v_s)) sgn θ̇: what Coulomb friction τ_c is less than itself while a joint creeps.

    v_s is a share of the axis' own rms velocity. No finding is made of it, and so the catalogue does not offer it: it
    says below which speed the model's Coulomb friction does not hold, and these rows are no steady motion
    (`search/creeping.py`).
    """

    name = "soft_coulomb"
    words = "Coulomb friction that turns round softly"
    place = "joint"
    sentence = "Coulomb friction turns round over a span of speeds instead of at once."
    coefficients = (Quantity("tau_c", "N·m", low=0.0, words="friction of constant size"),)
    shapes = (
        Shape(
            "v_s", "rms velocity", 0.005, 0.2, (0.01, 0.02, 0.04, 0.08, 0.16), words="speed over which it turns round"
        ),
    )
    confounds = ("coulomb", "viscous", "presliding")
    needs = "Several slow starts and reversals, and steady motion at low and at high speed."
    coordinate = "velocity"

    def columns(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        x = np.abs(signals.velocity) / (shape[0] * (signals.speed_scale or 1.0))
        return (signals.direction * (1.0 - np.tanh(x)))[:, None]

    def applies(self, signals: AxisSignals) -> bool:
        return bool(np.any(signals.direction != 0.0))


SOFT_COULOMB = SoftCoulomb()
