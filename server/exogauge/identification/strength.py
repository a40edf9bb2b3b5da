"""How strong the prior should be: as strong as predicts best what was left out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from exogauge.estimation.least_squares import PriorLeastSquares
from exogauge.estimation.prior import Prior
from exogauge.estimation.statistics import Statistics

Array = NDArray[np.float64]

NO_MATTER = 0.02  # of the score: a smaller difference is of no use to anyone
FEWEST_FOLDS = 2  # with rows in them; otherwise nothing can be left out, and the maker's word counts as stated
STRENGTHS = {
    "per_parameter": tuple(10.0**e for e in (-2, -1, 0, 1, 2, 3)),
    "as_printed": tuple(10.0**e for e in (-10, -8, -6, -4, -2)),
}


def choose_strength(
    folds: Sequence[Statistics], weights: Array, prior: Prior, kind: str
) -> tuple[float, tuple[tuple[float, float], ...]]:
    """(strength, ((strength, score), …)); score: mean weighted square residual of the parts left out in turn.

    Of the strengths that predict as well as the best, within one standard error of the difference from part to part
    or two per cent, the one nearest to what the maker states (1) is taken: a difference that chance could make is no
    reason to doubt him. Only parts of fitted logs are used; logs held out for validation stay unseen.
    """
    folds = [fold for fold in folds if fold.count @ (weights > 0.0) > 0]
    if len(folds) < FEWEST_FOLDS:
        return 1.0, ()
    complements = [sum((f for f in folds if f is not fold), start=folds[0].cleared()) for fold in folds]
    data = [rest.square_root(weights) for rest in complements]
    rows = np.array([float(fold.count @ (weights > 0.0)) for fold in folds])
    scores = np.empty((len(STRENGTHS[kind]), len(folds)))
    for row, strength in zip(scores, STRENGTHS[kind], strict=True):
        for index, (fold, rest) in enumerate(zip(folds, data, strict=True)):
            x = PriorLeastSquares(rest, prior, strength).x
            row[index] = weights @ fold.residual_square_sum(x) / rows[index]
    mean = scores @ rows / rows.sum()
    excess = scores - scores[np.argmin(mean)]
    error = excess.std(axis=1, ddof=1) / np.sqrt(len(folds))
    allowed = np.maximum(error, NO_MATTER * mean.min())
    as_good = [s for s, a, m in zip(STRENGTHS[kind], allowed, mean, strict=True) if m - mean.min() <= a]
    curve = tuple((float(s), float(m)) for s, m in zip(STRENGTHS[kind], mean, strict=True))
    return min(as_good, key=lambda s: abs(np.log(s))), curve
