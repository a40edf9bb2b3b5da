"""A band that grows stiffer as it is stretched."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.band import Array, BandSignals, Sort
from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Shape


@final
class BandHardening:
    """T = h x_t² (x/x_t)^p on top of k x, x = max(l - l_0, 0), x_t the travel of the band's length over all logs.

    With p = 2 it is h x². Whatever p, h is what the band pulls more, at a stretch of x_t, over x_t².
    """

    name = "band_hardening"
    words = "hardening"
    place = "band"
    sentence = "The band grows stiffer the further it is stretched."
    coefficients = (Quantity("hardening", "N/m²", low=0.0, words="stiffness that is gained with the stretch"),)
    shapes = (Shape("power", "1", 1.3, 4.5, (1.6, 2.0, 3.0), words="power of the stretch with which the pull grows"),)
    confounds = ("stiffness", "natural_length", "band_stiffness", "band_length")
    needs = "Motion that stretches the band from slack to far beyond its usual stretch, at even shares of time."
    coordinate = "stretch"
    once = False
    per_segment = False
    sort: Sort = "law"

    def added_tension(self, signals: BandSignals, shape: tuple[float, ...]) -> Array:
        (power,) = shape
        travel = max(signals.travel, 1e-9)
        return np.asarray(travel**2 * (signals.stretch / travel) ** power)[:, None]

    def applies(self, signals: BandSignals) -> bool:
        return bool(np.any(signals.stretch > 0.0))


EFFECT = BandHardening()
