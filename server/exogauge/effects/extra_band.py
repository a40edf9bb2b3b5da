"""A band that the description of the wear does not know."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.band import NOT_STATED, Array, BandSignals, Sort
from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Shape


@final
class ExtraBand:
    """T = k max(l - l_0, 0) of a further wire. slack: l_0 as a share of the wire's travel beyond its shortest length;
    below 0 it is taut throughout. Where only a joint is known that it pulls at, its angle stands for l."""

    name = "extra_band"
    words = "an undescribed pull"
    place = "band"
    sentence = "Something pulls that the description of the wear does not know."
    coefficients = (Quantity("extra_stiffness", "N/m", low=0.0, words="stiffness of the wire"),)
    shapes = (
        Shape(
            "slack",
            "travel",
            -2.0,
            0.9,
            (-1.0, -0.3, 0.0, 0.3, 0.6),
            words="natural length beyond the shortest length, in travels of the wire",
        ),
    )
    confounds = ("stiffness", "natural_length")
    needs = "Motion of every joint by itself that the wear may act on."
    coordinate = "stretch"
    once = False
    per_segment = False
    sort: Sort = "wire"
    law = ""
    stated = NOT_STATED

    def added_tension(self, signals: BandSignals, shape: tuple[float, ...]) -> Array:
        l_0 = signals.shortest + shape[0] * signals.travel
        return np.maximum(signals.length - l_0, 0.0)[:, None]

    def applies(self, signals: BandSignals) -> bool:
        return len(signals.time) > 0 and signals.travel > 0.0


EFFECT = ExtraBand()
