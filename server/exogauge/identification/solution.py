"""The passes over the data: collect, weigh, choose the prior's strength, solve, fill in static friction, again."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.identifying import Identifying
from exogauge.errors import NotIdentifiable
from exogauge.estimation.least_squares import PriorLeastSquares
from exogauge.estimation.prior import Prior
from exogauge.estimation.statistics import Form, Statistics
from exogauge.identification.equations import Equations
from exogauge.identification.gain_scale import GainScale, gain_scale
from exogauge.identification.preparation import Prepared
from exogauge.identification.prior import as_printed
from exogauge.identification.ranges import solve_within_ranges
from exogauge.identification.settings import Settings
from exogauge.identification.static_friction import Sticking, fill_static_friction
from exogauge.progress import Doing, Progress, unwatched
from exogauge.side_by_side import each as side_by_side

Array = NDArray[np.float64]

PASSES = 4  # over the data; each takes the static friction's sign and the noise-free currents from the one before
FOLDS = 4  # consecutive parts of a fitted log, left out in turn to choose the prior's strength
SMALLEST_SHARE = 1e-6  # of the signal: noise-free data must not give infinite weights
STRENGTHS = {
    "per_parameter": tuple(10.0**e for e in (-2, -1, 0, 1, 2, 3)),
    "as_printed": tuple(10.0**e for e in (-10, -8, -6, -4, -2)),
}


@final
@dataclass(frozen=True)
class Solution:
    """What the sign passes end with. weights: (rows,) 1/variance. curve: (strength, held-out score).

    held: names of joint parameters that stand at the edge of their physical range.
    x_before: (P,) parameters of the pass before, at which the statistics were collected.
    gains: what decides a scale that the data leave open.
    """

    solved: PriorLeastSquares
    statistics: Statistics
    weights: Array
    prior: Prior
    strength: float
    curve: tuple[tuple[float, float], ...]
    held: tuple[str, ...]
    sticking: Sticking
    x_before: Array
    gains: GainScale

    @cached_property
    def unbounded(self) -> PriorLeastSquares:
        """The same data and prior solved without physical ranges: what an effect is added to may leave an edge."""
        return self.of(self.statistics)

    def of(self, statistics: Statistics, weights: Array | None = None) -> PriorLeastSquares:
        """Statistics of the same equations, solved with the same beliefs, without physical ranges. weights: (rows,), if
        not the same."""
        root = statistics.square_root(self.weights if weights is None else weights)
        solved = PriorLeastSquares(root, self.prior, self.strength)
        solved.shift(self.gains.step)
        return solved


def solve(
    equations: Equations,
    fitted: Sequence[Prepared],
    prior: Prior,
    settings: Settings,
    progress: Progress = unwatched,
    passes: int = PASSES,
) -> Solution:
    """[Evaluator] (15) by `passes` passes over the data, each from what the one before found."""
    x, strength = prior.seen_mean, settings.prior_strength or 1.0
    curve: tuple[tuple[float, float], ...] = ()
    form: Form = "gram" if settings.solver == "statistics" else "factor"
    belief, criteria = prior, settings.criteria.identifying
    for number in range(passes):
        folds = Folds(FOLDS * len(fitted), criteria.most_folds)
        collected = side_by_side(partial(equations.collect, x_before=x, folds=FOLDS, form=form), fitted)
        for done, parts in enumerate(collected, number * len(fitted) + 1):
            folds.add(parts)
            progress(0.1 + 0.65 * done / (passes * len(fitted)), Doing.COLLECTING_EQUATIONS)
        total = folds.total
        if number == 0:
            weights = first_weights(equations, total, prior)
            if not weights.any():
                raise NotIdentifiable(
                    "no joint moves steadily in any fitted log (every sample is at rest, or near a start, a stop or a "
                    "turn), and no outside force is measured: there is nothing to identify from. Record longer "
                    "movements in one direction, or raise cutoff_hz: a higher one shortens what counts as near."
                )
        if settings.prior == "as_printed":
            belief = as_printed(equations, prior, total, weights)
        weights = weigh(total, belief, strength, weights)
        if settings.prior_strength is None and number == passes - 1:
            strength, curve = choose_strength(folds.parts, weights, belief, settings.prior, criteria)
            weights = weigh(total, belief, strength, weights)
        data = total.square_root(weights)
        nearest = PriorLeastSquares(data, belief, strength)
        gains = gain_scale(equations, total, weights, nearest)
        solved, held = solve_within_ranges(equations, data, nearest, gains.step)
        sticking = fill_static_friction(equations, total, prior, solved.x)
        x_before, x = x, sticking.x
    return Solution(solved, total, weights, belief, strength, curve, held, sticking, x_before, gains)


@final
class Folds:
    """What is left out in turn: each part of a log by itself, or so many together that there are no more than `most`.

    A part is some MB, whatever its length.
    """

    def __init__(self, parts: int, most: int) -> None:
        self._together, self._taken = -(-parts // most), 0
        self.parts: list[Statistics] = []
        self._total: Statistics | None = None

    @property
    def total(self) -> Statistics:
        """In the order in which they came."""
        assert self._total is not None
        return self._total

    def add(self, parts: Sequence[Statistics]) -> None:
        """The next ones."""
        for part in parts:
            self._total = part if self._total is None else self._total + part
            if self._taken % self._together:
                self.parts[-1] = self.parts[-1] + part
            else:
                self.parts.append(part)
            self._taken += 1


def weigh(statistics: Statistics, prior: Prior, strength: float, weights: Array) -> Array:
    """(rows,) 1/variance of the residuals, from solving and re-weighting in turn. Rows with weight 0 keep it."""
    iterations = 4  # of solving and re-weighting; 3 found noise stds within 3.3 % in trials
    seen = np.maximum(statistics.count, 1)
    signal = statistics.residual_square_sum(prior.seen_mean) / seen
    live = weights > 0.0
    for _ in range(iterations):
        x = PriorLeastSquares(statistics.square_root(weights), prior, strength).x
        variance = statistics.residual_square_sum(x) / seen
        weights = np.where(live, 1.0 / np.maximum(variance, SMALLEST_SHARE**2 * signal + 1e-300), 0.0)
    return weights


def first_weights(equations: Equations, statistics: Statistics, prior: Prior) -> Array:
    """(rows,) from what the a-priori robot leaves unexplained.

    0 for joints whose torque is not logged, and for axes that are not in steady motion (see `static_friction`), or for
    fewer samples than they have coefficients of their own: those explain so few rows exactly, whatever their noise.
    """
    variance = statistics.residual_square_sum(prior.seen_mean) / np.maximum(statistics.count, 1)
    measured = statistics.count > 0
    measured[equations.layout.axes] &= statistics.count[equations.layout.axes] > len(equations.effects)
    measured[equations.layout.axes] &= np.array([joint.actuation != "none" for joint in equations.robot.joints])
    measured[equations.layout.at_rest] = False
    return np.where(measured, 1.0 / np.maximum(variance, 1e-300), 0.0)


def choose_strength(
    folds: Sequence[Statistics], weights: Array, prior: Prior, kind: str, criteria: Identifying
) -> tuple[float, tuple[tuple[float, float], ...]]:
    """(strength, ((strength, score), …)); score: mean weighted square residual of the parts left out in turn.

    Of the strengths that predict as well as the best, within one standard error of the difference from part to part
    or two per cent, the one nearest to what the maker states (1) is taken: a difference that chance could make is no
    reason to doubt him. Only parts of fitted logs are used; logs held out for validation stay unseen.
    """
    folds = [fold for fold in folds if fold.count @ (weights > 0.0) > 0]
    if len(folds) < criteria.fewest_folds:
        return 1.0, ()
    rows = np.array([float(fold.count @ (weights > 0.0)) for fold in folds])

    def of_fold(left_out: tuple[Statistics, Statistics, float]) -> list[float]:
        rest, fold, count = left_out[0].square_root(weights), *left_out[1:]
        xs = (PriorLeastSquares(rest, prior, strength).x for strength in STRENGTHS[kind])
        return [float(weights @ fold.residual_square_sum(x) / count) for x in xs]

    each_left_out = zip(_rests(folds), folds, rows.tolist(), strict=True)
    scores = np.ascontiguousarray(np.array(list(side_by_side(of_fold, each_left_out))).T)
    mean = scores @ rows / rows.sum()
    excess = scores - scores[np.argmin(mean)]
    error = excess.std(axis=1, ddof=1) / np.sqrt(len(folds))
    allowed = np.maximum(error, criteria.no_matter * mean.min())
    as_good = [s for s, a, m in zip(STRENGTHS[kind], allowed, mean, strict=True) if m - mean.min() <= a]
    curve = tuple((float(s), float(m)) for s, m in zip(STRENGTHS[kind], mean, strict=True))
    return min(as_good, key=lambda s: abs(np.log(s))), curve


def _rests(folds: Sequence[Statistics]) -> Iterator[Statistics]:
    """Of each fold the sum of all others, those before and those behind it; none is held longer than it is needed."""
    behind = list(itertools.accumulate(folds[:0:-1], initial=folds[0].cleared()))
    before = folds[0].cleared()
    for fold in folds:
        yield before + behind.pop()
        before = before + fold
