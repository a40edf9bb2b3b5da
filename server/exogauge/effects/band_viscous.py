"""A damper beside the spring of a band."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.band import Array, BandSignals, Sort
from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Shape


@final
class BandViscous:
    """T = c l̇ where taut, on top of k x (Kelvin and Voigt). A cycle of amplitude A, always taut, costs π A² c ω."""

    name = "band_viscous"
    place = "band"
    sentence = "The band pulls more while it is stretched than while it shortens, in proportion to speed."
    coefficients = (Quantity("damping", "N·s/m", low=0.0),)
    shapes: tuple[Shape, ...] = ()
    confounds = ("band_via_friction", "band_relaxation")
    needs = "The same stretches slowly and fast, in both directions."
    coordinate = "rate"
    once = False
    per_segment = False
    sort: Sort = "law"

    def added_tension(self, signals: BandSignals, shape: tuple[float, ...]) -> Array:
        return (signals.taut * signals.rate)[:, None]

    def applies(self, signals: BandSignals) -> bool:
        taut = signals.stretch > 0.0
        return bool(np.any(signals.rate[taut] > 0.0) and np.any(signals.rate[taut] < 0.0))


EFFECT = BandViscous()
