"""The shape of a band's effect, searched once more with the bands' springs fitted to it in full.

Candidates are compared beside springs that move a little; a law that was named moves them by more.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from exogauge.criteria.wearing import Wearing
from exogauge.detect.device.baseline import Ground, weighed
from exogauge.detect.device.judge import BandJudgement, Folds, judge
from exogauge.detect.device.score import BandScore
from exogauge.effects.shaped import Shape
from exogauge.support.band_model import Added, fit

Array = NDArray[np.float64]


def with_best_shape(ground: Ground, winner: BandJudgement, folds: Folds) -> BandJudgement:
    """The winner, judged anew with the shape that fits best, if that may still be claimed and explains more of what was
    left out of the fit; else as it was. Of an effect of one moment nothing was left out."""
    added, without = winner.added, ground.fitted.wear
    shapes = added.effect.shapes
    free = [k for k, one in enumerate(shapes) if one.grid != (one.low, one.high)]
    if not free:
        return winner
    setting, criteria = weighed(ground, winner.fitted).setting, ground.model.criteria.device

    def tried(shares: Array) -> Added:
        shape = list(added.shape)
        for k, share in zip(free, np.clip(shares, 0.0, 1.0), strict=True):
            shape[k] = shapes[k].at(float(share))
        return replace(added, shape=tuple(shape))

    def cost(shares: Array) -> float:
        return fit(setting, without.with_added(tried(shares))).cost

    start = np.array([shapes[k].share(added.shape[k]) for k in free])
    steps = np.array([_first_step(shapes[k], criteria) for k in free]) * np.where(start < 0.9, 1.0, -1.0)
    found = minimize(
        cost, start, method="Nelder-Mead",
        options={"maxfev": criteria.trials * len(free), "initial_simplex": np.vstack([start, start + np.diag(steps)]),
                 "xatol": 0.005, "fatol": 1.0},
    )  # fmt: skip
    if found.fun > cost(start) - criteria.shape_worth:
        return winner
    again = judge(ground, BandScore(tried(found.x), 0.0, winner.evidence, winner.left), folds)
    better = winner.once or float(np.nansum(again.blocks)) > float(np.nansum(winner.blocks))
    return again if better and not again.objection else winner


def _first_step(shape: Shape, criteria: Wearing) -> float:
    """As a share of its range."""
    return criteria.first_step if len(shape.grid) < criteria.fine else 0.5 / len(shape.grid)
