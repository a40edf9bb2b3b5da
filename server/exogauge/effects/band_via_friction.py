"""A band that rubs where it is led round."""

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
class BandViaFriction:
    """T_{j+1} = T_j e^{-μ φ_j c_j} at via point j (capstan), the mean along the band k x; linear in μ about one tried.

    φ_j is the angle by which the band turns there. c_j, -1…1, is 1 where the band slides at point j towards the side it
    comes from, and takes some way w to become so after each turn, because the band, the cloth and whatever holds the
    point give way before it slides: dc/du = (1 - c s)^n / w, s = sgn du (Dahl), as a joint's `presliding`. u is what
    would slide without friction, l_0 times the share of the length that lies before the point. Every point is taken by
    itself.
    """

    name = "band_via_friction"
    words = "friction at the via points"
    place = "band"
    sentence = "The band rubs at its via points, so that its tension differs along its way."
    coefficients = (Quantity("friction", "1", low=0.0, words="coefficient of friction at the via points"),)
    shapes = (
        Shape("friction", "1", 0.01, 0.8, (0.1, 0.3), words="coefficient about which the law is taken as linear"),
        Shape(
            "way", "m", 1e-4, 0.03, (0.0003, 0.001, 0.003, 0.01), words="way over which friction builds up after a turn"
        ),
        Shape("n", "1", 1.0, 2.0, (1.0, 1.5), words="how unequal the ways are after which contacts slide"),
    )
    confounds = ("band_viscous", "stiffness")
    needs = "The same stretches at several speeds in both directions, with turns at several lengths."
    coordinate = "rate"
    once = False
    per_segment = True
    sort: Sort = "law"
    law = "via_friction"
    stated: Mapping[str, Stated] = MappingProxyType({
        "friction": Stated(0.2),
        "way": Stated(0.001, low=1e-6, high=1.0, default=0.0003),
        "n": Stated(1.3, low=1.0, high=2.0, default=1.0),
    })  # fmt: skip

    def added_tension(self, signals: BandSignals, shape: tuple[float, ...]) -> Array:
        least = 1e-9  # coefficient about which the law without friction is linear
        L, phi = signals.segment_length, signals.wrap
        if L is None or phi is None:
            return np.zeros((len(signals.time), 1, 1))
        mu, way, n = max(shape[0], least), *shape[1:]
        before = signals.natural_length * np.cumsum(L, axis=1)[:, :-1] / np.maximum(L.sum(axis=1, keepdims=True), 1e-9)
        c = np.stack([bristle(slid / way, n) for slid in before.T], axis=1) if before.size else before
        return self._pull(signals, L, phi * c, mu)[:, :, None]

    @staticmethod
    def _pull(signals: BandSignals, L: Array, held: Array, mu: float) -> Array:
        """(T, S) [N] per unit of μ. held: (T, S-1) [rad] φ c."""
        uneven = np.cumsum(signals.taut[:, None] * held, axis=1)
        ratio = np.exp(-mu * np.concatenate([np.zeros((len(L), 1)), uneven], axis=1))
        ratio /= np.sum(ratio * L, axis=1, keepdims=True) / np.maximum(L.sum(axis=1, keepdims=True), 1e-9)
        return np.asarray(signals.tension[:, None] * (ratio - 1.0) / mu)

    def applies(self, signals: BandSignals) -> bool:
        if signals.wrap is None or len(signals.time) < 2:  # rubbing takes a way
            return False
        return bool(np.any(signals.wrap * signals.taut[:, None] > 0.0))


EFFECT = BandViaFriction()
