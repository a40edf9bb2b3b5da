"""An anchor of a band that gives way once."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.band import NOT_STATED, Array, BandSignals, Sort
from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Shape


@final
class BandSlip:
    """T = -k Δl where taut, from one moment on: the natural length has grown by Δl.

    moment: share of the time of all logs laid end to end at which half of it is gone; it goes evenly, `within` [s].
    lasting: 1, it stays so in all later logs; 0, the band is back in its place when the next log begins.
    """

    name = "band_slip"
    words = "an anchor that slipped"
    place = "band"
    sentence = "An anchor of the band slips once, and the band is longer from then on."
    coefficients = (Quantity("slip", "m", low=0.0, words="length that the slip adds"),)
    shapes = (
        Shape(
            "moment",
            "share",
            0.0,
            1.0,
            tuple(np.linspace(0.0, 1.0, 121)[:-1].tolist()),
            words="when half of it is gone, on the clock of all logs with the device",
        ),
        Shape(
            "lasting",
            "1",
            0.0,
            1.0,
            (0.0, 1.0),
            words="1: later logs have it too, 0: the band is back when the next log begins",
        ),
        Shape("within", "s", 0.01, 1.0, (0.1,), words="how long the slip takes"),
    )
    confounds = ("natural_length", "band_relaxation")
    needs = "The same motion again after the slip, and once more after the band was put on anew."
    coordinate = "clock"
    once = True
    per_segment = False
    sort: Sort = "law"
    law = ""
    stated = NOT_STATED

    def added_tension(self, signals: BandSignals, shape: tuple[float, ...]) -> Array:
        moment, lasting, within = shape[0] * signals.span, shape[1] >= 0.5, shape[2]
        gone = np.clip((signals.clock - moment) / within + 0.5, 0.0, 1.0)
        if not lasting and moment < signals.start:
            gone = np.zeros_like(gone)
        return (-signals.stiffness * signals.taut * gone)[:, None]

    def applies(self, signals: BandSignals) -> bool:
        return bool(np.any(signals.stretch > 0.0))


EFFECT = BandSlip()
