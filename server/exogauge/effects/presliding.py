"""Friction that remembers where the motion last turned."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Array, AxisSignals, Shape


@final
class Presliding:
    """τ = -τ_p x, Dahl's friction: dx/dθ = (1 - x s)^n / d, s = sgn dθ, so that |x| <= 1 and x -> s after some d.

    Between two turns 1 - x s has a closed form (`bristle`). n = 1 lets all contacts slide after the same way; with
    a larger n some of them slide much later. A log starts with x = 0, from rest. d is a share of the axis' own range.
    Coulomb friction beside it is the part that has no memory.
    """

    name = "presliding"
    words = "presliding friction"
    place = "joint"
    sentence = "After a turn of the motion friction builds up over a short way, as surfaces bend before they slide."
    coefficients = (Quantity("tau_p", "N·m", low=0.0, words="friction that builds up after a turn"),)
    shapes = (
        Shape("d", "range", 0.0001, 0.3, (0.0005, 0.002, 0.008, 0.03, 0.12), words="way over which it builds up"),
        Shape("n", "1", 1.0, 2.0, (1.3,), words="how unequal the ways are after which contacts slide"),
    )
    confounds = ("coulomb", "static_friction")
    needs = "Many small and slow reversals at several positions."
    coordinate = "position"
    along_motion = True
    at_turns = True

    def columns(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        d, n = shape
        return -bristle(signals.position / (d * (signals.range or 1.0)), n)[:, None]

    def applies(self, signals: AxisSignals) -> bool:
        return bool(np.any(signals.direction > 0.0) and np.any(signals.direction < 0.0))


def bristle(way: Array, n: float) -> Array:
    """(T,) x of dx = (1 - x s)^n dw, s = sgn dw, along the way w (T,), from x = 0.

    With u = 1 - x s and u_0 at the last turn, u = u_0 (1 + (n-1) u_0^(n-1) |w - w_0|)^(-1/(n-1)), which for n = 1 is
    u_0 e^(-|w - w_0|).
    """
    from exogauge.loops.bristle import bend

    x = np.zeros(len(way))
    bend(np.ascontiguousarray(way), n, x)
    return x


EFFECT = Presliding()
