"""A damper beside the spring of a band."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import final

import numpy as np

from exogauge.effects.band import Array, BandSignals, Sort, Stated
from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Shape


@final
class BandViscous:
    """T = c v |l̇/v|^p sgn l̇ where taut, v = 0.1 m/s, on top of k x.

    With p = 1 it is c l̇ (Kelvin and Voigt), and a cycle of amplitude A, always taut, costs π A² c ω. Whatever p, c is
    what the band pulls more at v, over v. A p near 0 would be friction, which is `band_via_friction`.
    """

    name = "band_viscous"
    words = "viscous damping"
    place = "band"
    sentence = "The band pulls more while it is stretched than while it shortens, in proportion to speed."
    coefficients = (Quantity("damping", "N·s/m", low=0.0, words="tension per unit of speed, to the power given"),)
    shapes = (Shape("damping_power", "1", 0.5, 2.0, (0.7, 1.0, 1.4), words="power of the speed"),)
    confounds = ("band_via_friction", "band_relaxation")
    needs = "The same stretches slowly and fast, in both directions."
    coordinate = "rate"
    once = False
    per_segment = False
    sort: Sort = "law"
    law = "kelvin_voigt"
    stated: Mapping[str, Stated] = MappingProxyType({
        "damping": Stated(10.0),
        "damping_power": Stated(1.0, low=0.2, high=3.0, default=1.0),
    })  # fmt: skip

    def added_tension(self, signals: BandSignals, shape: tuple[float, ...]) -> Array:
        usual = 0.1  # [m/s] of a band on a body that moves
        (power,) = shape
        return np.asarray(signals.taut * np.sign(signals.rate) * usual * np.abs(signals.rate / usual) ** power)[:, None]

    def applies(self, signals: BandSignals) -> bool:
        taut = signals.stretch > 0.0
        return bool(np.any(signals.rate[taut] > 0.0) and np.any(signals.rate[taut] < 0.0))


EFFECT = BandViscous()
