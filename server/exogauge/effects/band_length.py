"""A band that is longer or shorter than it is said to be."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.band import NOT_STATED, Array, BandSignals, Sort
from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Shape


@final
class BandLength:
    """T = -k Δl_0 where taut, what k (l - l_0) changes by; l_0 is what is stated of the band."""

    name = "band_length"
    words = "a wrong natural length"
    place = "band"
    sentence = "The band begins to pull at another length than stated."
    coefficients = (Quantity("added_length", "m", words="natural length beyond the stated one"),)
    shapes: tuple[Shape, ...] = ()
    confounds = ("natural_length", "stiffness", "band_hardening")
    needs = "Slow motion through the posture at which the band comes taut, and far beyond it."
    coordinate = "stretch"
    once = False
    per_segment = False
    sort: Sort = "stated"
    law = ""
    stated = NOT_STATED

    def added_tension(self, signals: BandSignals, shape: tuple[float, ...]) -> Array:
        return (-signals.stiffness * signals.taut)[:, None]

    def applies(self, signals: BandSignals) -> bool:
        return bool(np.any(signals.stretch > 0.0))


EFFECT = BandLength()
