"""Viscous friction that falls as the joint warms up."""

from __future__ import annotations

from typing import final

import numpy as np
from scipy.signal import lfilter

from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Array, AxisSignals, Shape

REFERENCE = 25.0  # [°C] at which k_w is told
LEAST_DURATION = 20.0  # [s] without a thermometer


@final
class ThermalViscous:
    """τ = -k_w c θ̇, c the cold that is left: e^{-β (T_g - 25 °C)} with a thermometer, e^{-t/t_w} without one.

    The grease's temperature T_g follows the logged one with the time constant t_w. It thins by the share β per kelvin:
    some 0.03 for gears, and less where further warmth matters less. Without a thermometer every log is taken to start
    with a rested joint. k_w is the part of viscous friction that warmth takes away, on top of k_d.
    """

    name = "thermal_viscous"
    place = "joint"
    sentence = "Viscous friction falls as the joint warms up."
    coefficients = (Quantity("k_w", "N·m·s/rad", low=0.0),)
    shapes = (
        Shape("t_w", "s", 0.5, 1800.0, (2.0, 20.0, 100.0, 500.0)),
        Shape("beta", "1/K", 0.003, 0.09, (0.03,)),
    )
    departing = (Quantity("k_w_quadratic", "N·m·s/rad"), Quantity("k_w_cubic", "N·m·s/rad"))
    confounds = ("viscous",)
    needs = "The same motion cold and warm, or for minutes on end; a logged temperature helps."
    coordinate = "temperature"

    def columns(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        return -(signals.velocity * _cold(signals, shape))[:, None]

    def departures(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        """(T, 2) with c² and c³ in place of c."""
        cold = _cold(signals, shape)
        return -signals.velocity[:, None] * np.stack([cold**2, cold**3], axis=1)

    def applies(self, signals: AxisSignals) -> bool:
        if not np.any(signals.direction != 0.0):
            return False
        if signals.temperature is not None:
            return bool(np.all(np.isfinite(signals.temperature)))
        return float(np.ptp(signals.time)) >= LEAST_DURATION


def _cold(signals: AxisSignals, shape: tuple[float, ...]) -> Array:
    t_w, beta = shape
    if signals.temperature is None:
        return np.asarray(np.exp(-signals.time / t_w))
    return np.asarray(np.exp(-beta * (_followed(signals.temperature, signals.time, t_w) - REFERENCE)))


def _followed(values: Array, time: Array, time_constant: float) -> Array:
    """A first-order lag behind values (T,), settled at the first one."""
    if len(time) < 2:
        return values
    a = float(np.exp(-(time[-1] - time[0]) / (len(time) - 1) / time_constant))
    return np.asarray(lfilter([1.0 - a], [1.0, -a], values, zi=[a * values[0]])[0])


EFFECT = ThermalViscous()
