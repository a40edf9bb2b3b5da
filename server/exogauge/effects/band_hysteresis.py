"""A band whose threads rub on each other: it pulls more while it is stretched than while it shortens, however fast."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import final

import numpy as np

from exogauge.effects.band import Array, BandSignals, Sort, Stated
from exogauge.effects.effect import Quantity
from exogauge.effects.presliding import bristle
from exogauge.effects.shaped import Shape


@final
class BandHysteresis:
    """T = (1 + h c) k x: c, -1…1, comes to 1 on some way w after each turn, dc/dl = (1 - c s)^n / w, s = sgn dl (Dahl).

    The same all along the band, as threads rub on threads: a band that runs straight has no via point to rub at.
    """

    name = "band_hysteresis"
    words = "friction within the band"
    place = "band"
    sentence = "The band pulls more while it is stretched than while it shortens, by a share that no speed changes."
    coefficients = (Quantity("hysteresis", "1", low=0.0, high=0.6, words="share of the pull, up and down"),)
    shapes = (
        Shape(
            "thread_way",
            "m",
            1e-4,
            0.03,
            (0.0003, 0.001, 0.003, 0.01),
            words="way over which it builds up after a turn",
        ),
        Shape("thread_n", "1", 1.0, 2.0, (1.0, 1.5), words="how unequal the ways are after which threads slide"),
    )
    confounds = ("band_viscous", "band_via_friction", "stiffness")
    needs = "The same stretches at several speeds in both directions, with turns at several lengths."
    coordinate = "rate"
    once = False
    per_segment = False
    sort: Sort = "law"
    law = "hysteresis"
    stated: Mapping[str, Stated] = MappingProxyType({
        "hysteresis": Stated(0.1, high=1.0),
        "thread_way": Stated(0.001, low=1e-6, high=1.0, default=0.001),
        "thread_n": Stated(1.3, low=1.0, high=2.0, default=1.0),
    })  # fmt: skip

    def added_tension(self, signals: BandSignals, shape: tuple[float, ...]) -> Array:
        way, n = shape
        return np.asarray(signals.tension * bristle(signals.length / way, n))[:, None]

    def applies(self, signals: BandSignals) -> bool:
        taut = signals.stretch > 0.0
        return bool(np.any(signals.rate[taut] > 0.0) and np.any(signals.rate[taut] < 0.0))


EFFECT = BandHysteresis()
