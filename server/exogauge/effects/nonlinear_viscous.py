"""Friction that does not grow in proportion to speed."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Array, AxisSignals, Shape

KNOTS = (0.1, 0.25, 0.5, 1.0, 1.8, 3.0)  # speeds between which a curve of its own is bent, in rms velocities


@final
class NonlinearViscous:
    """τ = -τ_n (x / (1 + s x))^p sgn θ̇, x = |θ̇|/v with v the axis' own rms velocity: concave for p < 1, progressive for
    p > 1; s > 0 levels off, at τ_n / s^p.

    It comes on top of viscous friction k_d θ̇, so p = 1 without s says nothing and is not on the grid.
    """

    name = "nonlinear_viscous"
    words = "nonlinear viscous friction"
    place = "joint"
    sentence = "Friction grows with speed along a curve, not along a straight line."
    coefficients = (
        Quantity("tau_n", "N·m", low=0.0, words="friction at the usual speed, on top of the straight line"),
    )
    shapes = (
        Shape("power", "1", 0.25, 3.0, (0.33, 0.5, 0.7, 1.5, 2.0, 3.0), words="power of the speed"),
        Shape("levelling", "1", 0.0, 4.0, (0.0,), words="how soon the curve levels off"),
    )
    departing = (
        Quantity("tau_n_quadratic", "N·m"),
        Quantity("tau_n_cubic", "N·m"),
        *(Quantity(f"tau_at_{knot:g}", "N·m") for knot in KNOTS[:-1]),
    )
    confounds = ("viscous", "coulomb")
    needs = "Steady motion at many speeds from slow to the fastest."
    coordinate = "velocity"

    def columns(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        return (-_bent(signals, shape) * signals.direction)[:, None]

    def departures(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        """(T, 7) with 2p and 3p in place of p; then friction at one speed of `KNOTS` alone, falling linearly to
        nothing at its neighbours and at rest."""
        x = np.abs(signals.velocity) / (signals.speed_scale or 1.0)
        points = np.array([0.0, *KNOTS])
        hats = [np.interp(x, points, np.eye(len(points))[k]) for k in range(1, len(KNOTS))]
        own = _bent(signals, shape)
        return -np.stack([own**2, own**3, *hats], axis=1) * signals.direction[:, None]

    def applies(self, signals: AxisSignals) -> bool:
        return bool(np.any(signals.direction != 0.0))


def _bent(signals: AxisSignals, shape: tuple[float, ...]) -> Array:
    power, levelling = shape
    x = np.abs(signals.velocity) / (signals.speed_scale or 1.0)
    return np.asarray((x / (1.0 + levelling * x)) ** power)


EFFECT = NonlinearViscous()
