"""A band that grows stiffer as it is stretched."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import final

import numpy as np

from exogauge.effects.band import Array, BandSignals, Sort, Stated
from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Shape


@final
class BandHardening:
    """T = h X² (x/X)^p on top of k x, x = max(l - l_0, 0), X = 0.1 m.

    With p = 2 it is h x², and the stiffness rises by 2 h per metre. Whatever p, h X² is what the band pulls more at X.
    """

    name = "band_hardening"
    words = "hardening"
    place = "band"
    sentence = "The band grows stiffer the further it is stretched."
    coefficients = (Quantity("hardening", "N/m²", low=0.0, words="stiffness that is gained with the stretch"),)
    shapes = (
        Shape(
            "hardening_power", "1", 1.3, 4.5, (1.6, 2.0, 3.0), words="power of the stretch with which the pull grows"
        ),
    )
    confounds = ("stiffness", "natural_length", "band_stiffness", "band_length")
    needs = "Motion that stretches the band from slack to far beyond its usual stretch, at even shares of time."
    coordinate = "stretch"
    once = False
    per_segment = False
    sort: Sort = "law"
    law = "hardening"
    stated: Mapping[str, Stated] = MappingProxyType({
        "hardening": Stated(400.0),
        "hardening_power": Stated(2.0, low=1.0, high=5.0, default=2.0),
    })  # fmt: skip

    def added_tension(self, signals: BandSignals, shape: tuple[float, ...]) -> Array:
        usual = 0.1  # [m] stretch of a band on a body that moves
        (power,) = shape
        return np.asarray(usual**2 * (signals.stretch / usual) ** power)[:, None]

    def applies(self, signals: BandSignals) -> bool:
        return bool(np.any(signals.stretch > 0.0))


EFFECT = BandHardening()
