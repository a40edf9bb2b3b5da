"""A band that rubs where it is led round."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.band import Array, BandSignals, Sort
from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Shape


@final
class BandViaFriction:
    """T_{j+1} = T_j e^{-μ y_j} at via point j (capstan), the mean along the band k x; linear in μ about one tried.

    y_j runs between -φ_j and φ_j: +φ_j where the band slides at point j towards the side it comes from, which takes it
    some way after each turn, because both sides must first change by what friction held: y ← clip(y + Δu/d, ±φ). u is
    what would slide without friction, l_0 times the share of the length that lies before the point; the sides j and
    j+1, n_j and n_{j+1} of the unstretched band, change their tension by 1/d = (1/n_j + 1/n_{j+1}) l/(l - l_0) / μ per
    metre that sticks, over `give`: 1 where nothing but the band's own stretch gives way, more where the via point does
    as well. Every point is taken by itself.
    """

    name = "band_via_friction"
    place = "band"
    sentence = "The band rubs at its via points, so that its tension differs along its way."
    coefficients = (Quantity("friction", "1", low=0.0),)
    shapes = (
        Shape("stick", "1", 0.01, 0.8, (0.05, 0.1, 0.2, 0.4)),
        Shape("give", "1", 0.03, 10.0, (0.1, 1.0)),
    )
    confounds = ("band_viscous", "stiffness")
    needs = "The same stretches at several speeds in both directions, with turns at several lengths."
    coordinate = "rate"
    once = False
    per_segment = True
    sort: Sort = "law"

    def added_tension(self, signals: BandSignals, shape: tuple[float, ...]) -> Array:
        L, phi = signals.segment_length, signals.wrap
        if L is None or phi is None:
            return np.zeros((len(signals.time), 1, 1))
        mu, give = shape
        total = np.maximum(L.sum(axis=1, keepdims=True), 1e-9)
        u = signals.natural_length * np.cumsum(L, axis=1)[:, :-1] / total
        n = signals.natural_length * np.maximum(L, 1e-9) / total
        strain = np.maximum(signals.stretch / max(signals.natural_length, 1e-9), 1e-6)[:, None]
        per_metre = (1.0 / n[:, :-1] + 1.0 / n[:, 1:]) * (1.0 + strain) / (give * mu * strain)
        held = phi * signals.taut[:, None]
        y = clipped_sum(np.diff(u, axis=0, prepend=u[:1]) * per_metre, held)
        ratio = np.exp(-mu * np.concatenate([np.zeros((len(L), 1)), np.cumsum(y, axis=1)], axis=1))
        ratio /= np.sum(ratio * L, axis=1, keepdims=True) / total
        return (signals.tension[:, None] * (ratio - 1.0) / mu)[:, :, None]

    def applies(self, signals: BandSignals) -> bool:
        return bool(signals.wrap is not None and np.any(signals.wrap * signals.taut[:, None] > 0.0))


def clipped_sum(step: Array, most: Array) -> Array:
    """(T, S) y_t = clip(y_{t-1} + step_t, ±most_t) from 0 on. step, most: (T, S).

    Such steps join to one of the same form, clip(y + a, low, high): a log takes log₂ T passes and no loop over samples.
    """
    a, low, high, reach = step.copy(), -most, most.copy(), 1
    while reach < len(a):
        a_1, low_1, high_1 = a[:-reach].copy(), low[:-reach].copy(), high[:-reach].copy()
        a_2, low_2, high_2 = a[reach:], low[reach:].copy(), high[reach:].copy()
        low[reach:] = np.clip(low_1 + a_2, low_2, high_2)
        high[reach:] = np.clip(high_1 + a_2, low_2, high_2)
        a[reach:] = a_1 + a_2
        reach *= 2
    return np.asarray(np.clip(a, low, high))


EFFECT = BandViaFriction()
