"""Friction that remembers where the motion last turned."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Array, AxisSignals, Shape


@final
class Presliding:
    """τ = -τ_p x, Dahl's friction: dx = (dθ - |dθ| x) / d, so that |x| <= 1 and x -> sgn θ̇ after some d of sliding.

    Each step is exact: x ← s + (x - s) e^{-|Δθ|/d}, s = sgn Δθ. A log starts with x = 0, from rest. d is a share of the
    axis' own range. Coulomb friction beside it is the part that has no memory.
    """

    name = "presliding"
    place = "joint"
    sentence = "After a turn of the motion friction builds up over a short way, as surfaces bend before they slide."
    coefficients = (Quantity("tau_p", "N·m", low=0.0),)
    shapes = (Shape("d", "range", 0.002, 0.3, (0.005, 0.015, 0.05, 0.15)),)
    confounds = ("coulomb", "static_friction")
    needs = "Many small and slow reversals at several positions."
    coordinate = "position"

    def columns(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        (d,) = shape
        step = np.diff(signals.position, prepend=signals.position[:1])
        kept = np.exp(-np.abs(step) / (d * (signals.range or 1.0)))
        return -relaxed(kept, (1.0 - kept) * np.sign(step))[:, None]

    def applies(self, signals: AxisSignals) -> bool:
        return bool(np.any(signals.direction > 0.0) and np.any(signals.direction < 0.0))


def relaxed(kept: Array, gained: Array) -> Array:
    """(T,) x_k = kept_k x_{k-1} + gained_k from x = 0, kept within 0…1.

    Steps are joined two by two, then four by four, and so on: a log takes log₂ T passes and no loop over samples.
    """
    a, x, reach = kept.copy(), gained.copy(), 1
    while reach < len(x):
        x[reach:] += a[reach:] * x[:-reach]
        a[reach:] *= a[:-reach].copy()
        reach *= 2
    return x


EFFECT = Presliding()
