"""An anchor of a band that gives way once."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.band import Array, BandSignals, Sort
from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Shape


@final
class BandSlip:
    """T = -k Δl where taut, from one moment on: the natural length has grown by Δl.

    moment: share of the time of all logs laid end to end. lasting: 1, it stays so in all later logs; 0, the band is
    back in its place when the next log begins.
    """

    name = "band_slip"
    place = "band"
    sentence = "An anchor of the band slips once, and the band is longer from then on."
    coefficients = (Quantity("slip", "m", low=0.0),)
    shapes = (
        Shape("moment", "share", 0.0, 1.0, tuple(np.linspace(0.0, 1.0, 121)[:-1].tolist())),
        Shape("lasting", "1", 0.0, 1.0, (0.0, 1.0)),
    )
    confounds = ("natural_length", "band_relaxation")
    needs = "The same motion again after the slip, and once more after the band was put on anew."
    coordinate = "clock"
    once = True
    per_segment = False
    sort: Sort = "law"

    def added_tension(self, signals: BandSignals, shape: tuple[float, ...]) -> Array:
        moment, lasting = shape[0] * signals.span, shape[1] >= 0.5
        after = signals.clock >= moment
        if not lasting:
            after = after & (moment >= signals.start)
        return (-signals.stiffness * signals.taut * after)[:, None]

    def applies(self, signals: BandSignals) -> bool:
        return bool(np.any(signals.stretch > 0.0))


EFFECT = BandSlip()
