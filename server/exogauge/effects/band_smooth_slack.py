"""A band that comes taut gradually, as cloth does."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import final

import numpy as np

from exogauge.effects.band import Array, BandSignals, Sort, Stated
from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Shape


@final
class BandSmoothSlack:
    """T = g k (δ ln(1 + e^{u/δ}) - max(u, 0)) on top of k x, u = l - l_0, x = max(u, 0); g = 1: all of the band does.

    At most k δ ln 2 above the linear law, at u = 0. Stated, not looked for: a free natural length takes its place.
    """

    name = "band_smooth_slack"
    words = "gradual tightening"
    place = "band"
    sentence = "The band comes taut gradually, over a transition about its natural length."
    coefficients = (Quantity("gradual", "1", low=0.0, high=1.0, words="share of the band that comes taut gradually"),)
    shapes = (Shape("transition", "m", 1e-4, 0.05, (), words="stretch over which it comes taut"),)
    confounds = ("natural_length", "band_hardening")
    needs = "Slow motion through the posture at which the band comes taut."
    coordinate = "stretch"
    once = False
    per_segment = False
    sort: Sort = "law"
    law = "smooth_slack"
    stated: Mapping[str, Stated] = MappingProxyType({
        "transition": Stated(0.005),
        "gradual": Stated(1.0, high=1.0, default=1.0),
    })  # fmt: skip

    def added_tension(self, signals: BandSignals, shape: tuple[float, ...]) -> Array:
        (delta,) = shape
        u = signals.length - signals.natural_length
        if delta <= 0.0:
            return np.zeros((len(u), 1))
        with np.errstate(under="ignore"):  # far from its natural length nothing is added
            return np.asarray(signals.stiffness * delta * np.log1p(np.exp(-np.abs(u) / delta)))[:, None]

    def applies(self, signals: BandSignals) -> bool:
        return bool(np.any(signals.stretch > 0.0))


EFFECT = BandSmoothSlack()
