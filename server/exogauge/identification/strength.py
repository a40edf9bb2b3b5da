"""How strong the prior should be: as strong as predicts best what was left out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from exogauge.estimation.least_squares import PriorLeastSquares
from exogauge.estimation.prior import Prior
from exogauge.estimation.statistics import Statistics

Array = NDArray[np.float64]

STRENGTHS = {
    "per_parameter": tuple(10.0**e for e in (-2, -1, 0, 1, 2, 3)),
    "as_printed": tuple(10.0**e for e in (-10, -8, -6, -4, -2)),
}


def choose_strength(
    folds: Sequence[Statistics], total: Statistics, weights: Array, prior: Prior, kind: str
) -> tuple[float, tuple[tuple[float, float], ...]]:
    """(strength, ((strength, score), …)); score: mean weighted square residual of the parts left out in turn.

    Only parts of fitted logs are used; logs held out for validation stay unseen.
    """
    complements = [sum((f for f in folds if f is not fold), start=folds[0].cleared()) for fold in folds]
    data = [rest.square_root(weights) for rest in complements]
    curve = []
    for strength in STRENGTHS[kind]:
        solutions = [PriorLeastSquares(rest, prior, strength).x for rest in data]
        left_out = sum(
            weights @ (fold.residual_square_sum(x) - fold.noise_square_sum(x))
            for fold, x in zip(folds, solutions, strict=True)
        )
        curve.append((strength, float(left_out) / float(total.count @ (weights > 0.0))))
    return min(curve, key=lambda point: point[1])[0], tuple(curve)
