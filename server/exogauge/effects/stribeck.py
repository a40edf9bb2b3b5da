"""Friction that is larger at low speed."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Array, AxisSignals, Shape


@final
class Stribeck:
    """τ = -τ_b e^{-|θ̇/v_s|^δ} sgn θ̇, what is left of Stribeck's curve once Coulomb and viscous friction are taken out.

    v_s is a share of the axis' own rms velocity. Nothing is said of rest, where direction is 0.
    """

    name = "stribeck"
    words = "Stribeck friction"
    place = "joint"
    sentence = "Friction is larger at low speed and falls as the joint gets faster."
    coefficients = (Quantity("tau_b", "N·m", low=0.0, words="friction at the lowest speed, above Coulomb's"),)
    shapes = (
        Shape("v_s", "rms velocity", 0.01, 1.0, (0.03, 0.07, 0.15, 0.3, 0.6), words="speed over which it falls"),
        Shape("delta", "1", 0.5, 2.5, (1.0, 2.0), words="how abruptly it falls"),
    )
    confounds = ("coulomb", "viscous", "static_friction")
    needs = "Several slow reversals, and steady motion at low and at high speed."
    coordinate = "velocity"

    def columns(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        v_s, delta = shape
        x = np.abs(signals.velocity) / (v_s * (signals.speed_scale or 1.0))
        return (-signals.direction * np.exp(-(x**delta)))[:, None]

    def applies(self, signals: AxisSignals) -> bool:
        return bool(np.any(signals.direction != 0.0))


EFFECT = Stribeck()
