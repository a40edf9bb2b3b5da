"""A band that grows stiffer as it is stretched."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.band import Array, BandSignals, Sort
from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Shape


@final
class BandHardening:
    """T = k_2 x² on top of k x, x = max(l - l_0, 0)."""

    name = "band_hardening"
    place = "band"
    sentence = "The band grows stiffer the further it is stretched."
    coefficients = (Quantity("hardening", "N/m²", low=0.0),)
    shapes: tuple[Shape, ...] = ()
    confounds = ("stiffness", "natural_length", "band_stiffness", "band_length")
    needs = "Motion that stretches the band from slack to far beyond its usual stretch, at even shares of time."
    coordinate = "stretch"
    once = False
    per_segment = False
    sort: Sort = "law"

    def added_tension(self, signals: BandSignals, shape: tuple[float, ...]) -> Array:
        return np.square(signals.stretch)[:, None]

    def applies(self, signals: BandSignals) -> bool:
        return bool(np.any(signals.stretch > 0.0))


EFFECT = BandHardening()
