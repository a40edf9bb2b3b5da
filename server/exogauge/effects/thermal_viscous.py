"""Viscous friction that falls as the joint warms up."""

from __future__ import annotations

from typing import final

import numpy as np
import scipy

from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Array, AxisSignals, Shape


@final
class ThermalViscous:
    """τ = k_w g θ̇, g the share that warmth has taken away: from 0 at 25 °C to 1 at 35 °C with a thermometer,
    (1 - e^{-β (T_g - 25 °C)}) / (1 - e^{-β 10 K}), and 1 - e^{-t/t_w} without one.

    The grease's temperature T_g follows the logged one with the time constant t_w. Further warmth matters less with
    β > 0 (some 0.03 for gears), alike with 0. Without a thermometer every log is taken to start with a rested joint.
    k_d of the joint is that at 25 °C, or of the rested joint: what the maker says of it does not hold back how much
    warmth may take.
    """

    name = "thermal_viscous"
    words = "temperature-dependent friction"
    place = "joint"
    sentence = "Viscous friction falls as the joint warms up."
    coefficients = (Quantity("k_w", "N·m·s/rad", low=0.0, words="viscous friction that the warmth takes away"),)
    shapes = (
        Shape("t_w", "s", 0.5, 1800.0, (2.0, 20.0, 100.0, 500.0), words="time in which the joint warms up"),
        Shape("beta", "1/K", 0.0, 0.09, (0.02,), words="share by which grease thins per kelvin"),
    )
    departing = (Quantity("k_w_quadratic", "N·m·s/rad"), Quantity("k_w_cubic", "N·m·s/rad"))
    confounds = ("viscous",)
    needs = "The same motion cold and warm, or for minutes on end; a logged temperature helps."
    coordinate = "temperature"

    def columns(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        return (signals.velocity * _taken(signals, shape))[:, None]

    def departures(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        """(T, 2) with g² and g³ in place of g."""
        taken = _taken(signals, shape)
        return signals.velocity[:, None] * np.stack([taken**2, taken**3], axis=1)

    def applies(self, signals: AxisSignals) -> bool:
        least_duration = 20.0  # [s] without a thermometer
        if not np.any(signals.direction != 0.0):
            return False
        if signals.temperature is not None:
            return bool(np.all(np.isfinite(signals.temperature)))
        return float(np.ptp(signals.time)) >= least_duration


def _taken(signals: AxisSignals, shape: tuple[float, ...]) -> Array:
    """(T,) g"""
    warmer = 10.0  # [K] beyond it, which take k_w away
    reference = 25.0  # [°C] at which k_d is told: nothing is taken away yet
    t_w, beta = shape
    if signals.temperature is None:
        return np.asarray(-np.expm1(-signals.time / t_w))
    warmth = _followed(signals.temperature, signals.time, t_w) - reference
    if abs(beta) < 1e-6:
        return np.asarray(warmth / warmer)
    return np.asarray(np.expm1(-beta * warmth) / np.expm1(-beta * warmer))


def _followed(values: Array, time: Array, time_constant: float) -> Array:
    """A first-order lag behind values (T,), settled at the first one."""
    if len(time) < 2:
        return values
    a = float(np.exp(-(time[-1] - time[0]) / (len(time) - 1) / time_constant))
    return np.asarray(scipy.signal.lfilter([1.0 - a], [1.0, -a], values, zi=[a * values[0]])[0])


EFFECT = ThermalViscous()
