"""What a candidate would gain: the baseline fitted again beside it, by one small solve in the sums."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.estimation.least_squares import PriorLeastSquares, bounded_least_squares
from exogauge.identification.model import RobotModel
from exogauge.search.candidates import Candidate
from exogauge.search.sums import KindSums

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Baseline:
    """The model that candidates stand beside, fitted with rows that weigh as many samples as they are worth.

    Where something is missing, residuals are coloured, and rows that count in full let parameters run far beyond what
    is believed of them, into its place. memory: kind of row -> samples of the fitted logs that count as one.
    """

    model: RobotModel
    memory: Mapping[int, float]

    @cached_property
    def weights(self) -> Array:
        """(rows,)"""
        weights = self.model.solution.weights
        return np.array([weight / self.memory.get(kind, 1.0) for kind, weight in enumerate(weights)])

    @cached_property
    def solved(self) -> PriorLeastSquares:
        return self.model.solution.of(self.model.solution.statistics, self.weights)

    @cached_property
    def step(self) -> Array:
        """(P,) from the model's own solution, at which residuals are told, to this one."""
        return self.solved.x - self.model.solution.unbounded.x

    @cached_property
    def around(self) -> tuple[tuple[float, Array, Array], ...]:
        """`Statistics.around` of every kind of rows at this solution."""
        statistics = self.model.solution.statistics
        return tuple(statistics.around(kind, self.solved.x) for kind in range(len(self.weights)))


@final
@dataclass(frozen=True)
class Score:
    """gain: reduction of the fitted cost [weighted squares]. evidence: twice the log likelihood that rows gain, with
    coloured residuals, less what the prior loses and a price per value that was chosen (BIC). coefficients: (C,).
    without, step: (P,) from the model's own solution to the baseline, without the candidate and with it. left: share
    that the baseline cannot take its place in, 0…1.
    elsewhere: whether most of what rows gain lies in rows that it is not in, through the baseline that it sets right.
    """

    candidate: Candidate
    gain: float
    evidence: float
    coefficients: Array
    without: Array
    step: Array
    left: float
    elsewhere: bool = False


def score(baseline: Baseline, candidate: Candidate, sums: Mapping[int, KindSums]) -> Score | None:
    """sums: of the candidate's columns over the fitted logs, by kind of row, at the model's own solution.

    None where the baseline swallows it, or nothing weighs.
    """
    return next(iter(score_all(baseline, [candidate], sums)), None)


def score_all(baseline: Baseline, candidates: Sequence[Candidate], sums: Mapping[int, KindSums]) -> Iterator[Score]:
    """Those of one site that the baseline does not swallow, by one solve for all. sums: of their columns, in order."""
    blind = 1e-9  # share of a column left once the baseline is taken out, below which the baseline swallows it
    model, weights, own = baseline.model, baseline.weights, baseline.model.equations.columns()
    live = {kind: each.at(baseline.step[own[kind]]) for kind, each in sums.items() if weights[kind] > 0.0 and each.rows}
    if not live:
        return
    C = sum(candidate.width for candidate in candidates)
    B, squares, g = np.zeros((model.equations.size, C)), np.zeros((C, C)), np.zeros(C)
    for kind, each in live.items():
        B[own[kind]] += weights[kind] * each.cross.T
        squares += weights[kind] * each.own
        g += weights[kind] * each.with_residual
    V = baseline.solved.divided(B)
    start, fitted = 0, list[_Fitted]()
    for candidate in candidates:
        part = slice(start, start + candidate.width)
        start += candidate.width
        size = np.sqrt(np.maximum(np.diag(squares)[part], 1e-300))
        S = (squares[part, part] - B[:, part].T @ V[:, part]) / np.outer(size, size)
        left = float(S[0, 0] if len(S) == 1 else np.min(np.linalg.eigvalsh(S)))
        if left < blind:
            continue
        theta = _within_range(S, g[part] / size, candidate, size)
        gain = float(2.0 * (g[part] / size) @ theta - theta @ S @ theta)
        coefficients = theta / size
        fitted.append(_Fitted(candidate, part, gain, coefficients, -V[:, part] @ coefficients, left))
    for one, (evidence, elsewhere) in zip(fitted, _evidence(baseline, fitted, live), strict=True):
        moved = baseline.step + one.step
        yield Score(one.candidate, one.gain, evidence, one.coefficients, baseline.step, moved, one.left, elsewhere)


@final
@dataclass(frozen=True)
class _Fitted:
    """A candidate fitted beside the baseline. part: its columns among those of the site. step: (P,) what the baseline
    moves by."""

    candidate: Candidate
    part: slice
    gain: float
    coefficients: Array
    step: Array
    left: float


def _evidence(baseline: Baseline, fitted: Sequence[_Fitted], sums: Mapping[int, KindSums]) -> list[tuple[float, bool]]:
    """Of each: what every kind of row gains in log likelihood, its variance estimated anew, less what the prior loses;
    and whether more than half of the gain lies elsewhere than in its own rows.

    The baseline moves with the candidate, so rows gain and lose that it is not in.
    """
    nearly_all = 0.999  # of the square sum: no candidate is credited with more
    if not fitted:
        return []
    statistics, memory = baseline.model.solution.statistics, baseline.memory
    own = baseline.model.equations.columns()
    steps = np.stack([each.step for each in fitted], axis=1)  # (P, n)
    theta = np.concatenate([each.coefficients for each in fitted])
    columns = np.concatenate([np.arange(each.part.start, each.part.stop) for each in fitted])
    whose = np.repeat(np.arange(len(fitted)), [len(each.coefficients) for each in fitted])
    starts, together = np.flatnonzero(np.diff(whose, prepend=-1)), whose[:, None] == whose
    total, explained, independent = np.zeros(len(fitted)), np.zeros(len(fitted)), 0.0
    in_own_rows = np.zeros(len(fitted))
    for kind, weight in enumerate(baseline.weights):
        rows = int(statistics.count[kind])
        if weight <= 0.0 or not rows:
            continue
        before, slope, curvature = baseline.around[kind]
        D = steps[own[kind]]
        change = np.sum(D * (curvature @ D), axis=0) - 2.0 * slope @ D
        if kind in sums:
            cross, right, own_squares = sums[kind].of(columns)
            with_rows = np.einsum("ck,kc->c", cross, D[:, whose]) - right
            squares = np.where(together, own_squares, 0.0) @ theta
            change += np.add.reduceat(theta * (2.0 * with_rows + squares), starts)
            independent += sums[kind].rows / memory[kind]
        left = np.clip(1.0 + change / max(before, 1e-300), 1.0 - nearly_all, None)
        gained = -rows / memory[kind] * np.log(left)
        total += gained
        in_own_rows += gained if kind in sums else 0.0
        explained -= weight * change
    prior = np.maximum(explained - np.array([each.gain for each in fitted]), 0.0)
    price = np.array([len(each.coefficients) + len(each.candidate.shape) for each in fitted])
    evidence = total - prior - price * np.log(max(independent, 2.0))
    elsewhere = in_own_rows < 0.5 * total
    return [(float(value), bool(other)) for value, other in zip(evidence, elsewhere, strict=True)]


def _within_range(S: Array, g: Array, candidate: Candidate, size: Array) -> Array:
    """(C,) least squares in scaled coefficients, each within its physical range."""
    quantities = candidate.effect.coefficients
    low, high = (np.array([getattr(each, end) for each in quantities]) * size for end in ("low", "high"))
    return bounded_least_squares(S, g, low, high)


def residual_memory(residuals: Array) -> float:
    """Samples of one kind of row's residuals (n,) that count as one: their integral correlation time. NaN: gaps."""
    e = np.nan_to_num(residuals)
    used = np.isfinite(residuals)
    n = len(e)
    if used.sum() < 20:
        return 1.0
    e = np.where(used, e - e[used].mean(), 0.0)
    products, pairs = (np.fft.irfft(np.abs(np.fft.rfft(x, 2 * n)) ** 2)[: n // 2] for x in (e, used.astype(float)))
    rho = products / np.maximum(pairs, 1.0)
    rho = rho / max(float(rho[0]), 1e-300)
    positive = np.cumprod(rho > 0.0)
    return float(1.0 + 2.0 * np.sum(rho[1:] * positive[1:]))
