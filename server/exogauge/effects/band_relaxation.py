"""Further springs in a band that let go with time."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import final

import numpy as np

from exogauge.effects.band import Array, BandSignals, Sort, Stated, relaxed
from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Shape


@final
class BandRelaxation:
    """T = k_M s + k_S s' where taut, on top of k x (Maxwell): ṡ = ẋ - s/τ_r, x the stretch, s from 0 at the log's
    start; s' the same with 5 τ_r, because rubber lets go over decades of time.

    A cycle x = x_0 + A sin ωt, always taut, costs π A² k_M ω τ_r / (1 + ω² τ_r²) by each branch. τ_r is not looked for
    below 0.15 s: what lets go faster than people move is a damper, k_M τ_r.
    The step is exact for a stretch that changes evenly between samples: s ← E s + τ_r (1 - E) Δx/h, E = e^{-h/τ_r}.
    """

    name = "band_relaxation"
    words = "relaxation"
    place = "band"
    sentence = "Held at one stretch, the band's pull falls off with time; stretched fast, it is stiffer."
    coefficients = (
        Quantity("branch_stiffness", "N/m", low=0.0, words="stiffness that relaxes"),
        Quantity("slow_branch_stiffness", "N/m", low=0.0, words="stiffness that relaxes five times as slowly"),
    )
    shapes = (Shape("relaxation_time", "s", 0.15, 60.0, (0.3, 0.8, 2.0, 6.0, 20.0), words="time in which it relaxes"),)
    confounds = ("band_viscous", "stiffness")
    needs = "Quick stretches that are then held for several times as long as the pull takes to settle."
    coordinate = "rate"
    once = False
    per_segment = False
    sort: Sort = "law"
    law = "maxwell"
    stated: Mapping[str, Stated] = MappingProxyType({
        "branch_stiffness": Stated(50.0),
        "relaxation_time": Stated(0.5),
        "slow_branch_stiffness": Stated(50.0, default=0.0),
    })  # fmt: skip

    def added_tension(self, signals: BandSignals, shape: tuple[float, ...]) -> Array:
        slower = 5.0  # times as long the second branch takes
        return np.stack([_let_go(signals, tau) for tau in (shape[0], slower * shape[0])], axis=1)

    def applies(self, signals: BandSignals) -> bool:
        return bool(len(signals.time) > 1 and np.ptp(signals.stretch) > 0.0)


def _let_go(signals: BandSignals, tau: float) -> Array:
    """(T,) [m] what is left of the stretch in one branch, where the band is taut."""
    instant = 1e-9  # [s] what lets go within this holds nothing
    step = np.diff(signals.time, prepend=signals.time[:1]) / max(tau, instant)
    kept = np.exp(-step)
    driven = np.divide(-np.expm1(-step), step, out=np.ones_like(step), where=step > 0.0)
    rise = np.diff(signals.stretch, prepend=signals.stretch[:1])
    return np.asarray(signals.taut * relaxed(kept, driven * rise))


EFFECT = BandRelaxation()
