"""A band that is softer or stiffer than it is said to be."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.band import NOT_STATED, Array, BandSignals, Sort
from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Shape


@final
class BandStiffness:
    """T = Δk x on top of k x, x = max(l - l_0, 0); k is what is stated of the band."""

    name = "band_stiffness"
    words = "a wrong stiffness"
    place = "band"
    sentence = "The band is softer or stiffer than stated."
    coefficients = (Quantity("added_stiffness", "N/m", words="stiffness beyond the stated one"),)
    shapes: tuple[Shape, ...] = ()
    confounds = ("stiffness", "natural_length", "band_hardening")
    needs = "Motion that stretches the band from slack to far beyond its usual stretch."
    coordinate = "stretch"
    once = False
    per_segment = False
    sort: Sort = "stated"
    law = ""
    stated = NOT_STATED

    def added_tension(self, signals: BandSignals, shape: tuple[float, ...]) -> Array:
        return signals.stretch[:, None]

    def applies(self, signals: BandSignals) -> bool:
        return bool(np.any(signals.stretch > 0.0))


EFFECT = BandStiffness()
