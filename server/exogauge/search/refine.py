"""Shapes between the values of a grid: those with which the candidate explains most of the fitted logs.

Near a shape that the baseline swallows the predicted gain is all rounding; the evidence, which counts what the rows
really gain, vanishes there, and the search turns back. On the way to a better shape it may fall a little.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from exogauge.criteria.searching import Searching
from exogauge.search.score import Baseline, Score, residual_memory, score
from exogauge.search.site_rows import SiteRows, sums_of

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Pace:
    """first, last: step of a shape, in shares of its range. last_gain: of the gain, that a last step is worth."""

    first: float
    last: float
    last_gain: float


def broadly(criteria: Searching) -> Pace:
    return Pace(*criteria.broadly)


def closely(criteria: Searching) -> Pace:
    return Pace(*criteria.closely)


def closest(baseline: Baseline, of_grid: Sequence[Score], rows: Sequence[SiteRows]) -> Score:
    """What the best starts lead to. of_grid: of one effect at one site, most evidence first."""
    first = of_grid[0]
    free = [one for one in first.candidate.effect.shapes if not one.choice]
    criteria = baseline.model.criteria.search
    starts = of_grid[: criteria.starts if len(free) > 1 else 1]
    ends = climbed(baseline, starts, rows, (broadly(criteria),))
    return max((each for each in ends if each.evidence >= first.evidence), key=lambda each: each.gain)


def climbed(
    baseline: Baseline, starts: Sequence[Score], rows: Sequence[SiteRows], paces: Sequence[Pace]
) -> list[Score]:
    """What each start leads to, one pace after the other."""
    ends = list(starts)
    for pace in paces:
        ends = [refined(baseline, each, rows, pace) for each in ends]
    return ends


def with_it(baseline: Baseline, found: Score, rows: Sequence[SiteRows]) -> Baseline:
    """The same model, its rows weighing what they are worth once the candidate is there: what is left is coloured
    less, and numbers are drawn less to what was believed before."""
    own, effect, shape = baseline.model.equations.columns(), found.candidate.effect, found.candidate.shape
    left: dict[int, list[float]] = {}
    for each in rows:
        if not each.held_out:
            for kind, e in each.after(each.columns(effect, shape), found.coefficients, found.step, own).items():
                left.setdefault(kind, []).append(residual_memory(e))
    known = {kind: float(np.median(memories)) for kind, memories in left.items()}
    return replace(baseline, memory={**baseline.memory, **known})


def refined(baseline: Baseline, first: Score, rows: Sequence[SiteRows], pace: Pace | None = None) -> Score:
    """The candidate with its shapes searched from those it has, within their bounds; broadly, if not otherwise said."""
    candidate, criteria = first.candidate, baseline.model.criteria.search
    pace = pace or broadly(criteria)
    shapes = candidate.effect.shapes
    free = [k for k, one in enumerate(shapes) if not one.choice]
    if not free:
        return first

    def at(values: Array) -> Score | None:
        shape = list(candidate.shape)
        for k, u in zip(free, values, strict=True):
            shape[k] = shapes[k].at(u)
        sums = sums_of(rows, candidate.effect, tuple(shape))
        return score(baseline, replace(candidate, shape=tuple(shape)), sums)

    def cost(values: Array) -> float:
        found = at(np.clip(values, 0.0, 1.0))
        return 0.0 if found is None or found.evidence < criteria.swallowed * first.evidence else -found.gain

    start = np.array([shapes[k].share(candidate.shape[k]) for k in free])
    simplex = np.vstack(
        [
            start,
            *(start + (pace.first if u < 0.9 else -pace.first) * np.eye(len(start))[k] for k, u in enumerate(start)),
        ]
    )
    best = minimize(
        cost, start, method="Nelder-Mead", options={"maxfev": criteria.trials * len(free), "initial_simplex": simplex,
                                                    "xatol": pace.last, "fatol": pace.last_gain * first.gain},
    )  # fmt: skip
    found = at(np.clip(best.x, 0.0, 1.0))
    better = found is not None and found.evidence >= first.evidence and found.gain > first.gain
    return found if found is not None and better else first
