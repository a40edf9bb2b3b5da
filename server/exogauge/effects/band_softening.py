"""A band that grows softer as it is stretched, as rubber does at first."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import final

import numpy as np

from exogauge.effects.band import Array, BandSignals, Sort, Stated
from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Shape


@final
class BandSoftening:
    """T = -s U² g(x)/g(U) on top of k x, g(x) = x - X ln(1 + x/X), x = max(l - l_0, 0), U = 0.1 m.

    Whatever X, s U² is what the band pulls less at U. The stiffness is k where it comes taut, and half of what it loses
    is lost at x = X; with a large X it falls by 2 s per metre, as that of a band that hardens rises. A neo-Hookean
    band, whose stiffness is k (1 + 2 λ⁻³)/3 at λ = 1 + x/l_0, is met to 0.3 % of its pull up to λ = 1.5.
    """

    name = "band_softening"
    words = "softening"
    place = "band"
    sentence = "The band grows softer the further it is stretched."
    coefficients = (Quantity("softening", "N/m²", low=0.0, words="stiffness that is lost with the stretch"),)
    shapes = (
        Shape("softening_stretch", "m", 0.01, 1.0, (0.03, 0.1, 0.3), words="stretch by which half of what is lost is"),
    )
    confounds = ("stiffness", "natural_length", "band_stiffness", "band_length")
    needs = "Motion that stretches the band from slack to far beyond its usual stretch, at even shares of time."
    coordinate = "stretch"
    once = False
    per_segment = False
    sort: Sort = "law"
    law = "softening"
    stated: Mapping[str, Stated] = MappingProxyType({
        "softening": Stated(400.0),
        "softening_stretch": Stated(0.2, low=1e-3),
    })  # fmt: skip

    def added_tension(self, signals: BandSignals, shape: tuple[float, ...]) -> Array:
        usual = 0.1  # [m] stretch of a band on a body that moves
        half = shape[0]
        lost, at_usual = (x - half * np.log1p(x / half) for x in (signals.stretch, np.array(usual)))
        return np.asarray(-(usual**2) / at_usual * lost)[:, None]

    def applies(self, signals: BandSignals) -> bool:
        return bool(np.any(signals.stretch > 0.0))


EFFECT = BandSoftening()
