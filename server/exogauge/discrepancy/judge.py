"""Whether a candidate may be claimed: on logs that were not fitted, block by block, regime by regime."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.stats import rankdata

from exogauge.discrepancy.axis_rows import AxisRows
from exogauge.discrepancy.score import Score
from exogauge.identification.model import RobotModel

Array = NDArray[np.float64]

BLOCK_S = 1.0  # length of the parts that count as independent
FEWEST_BLOCKS = 5
SURE = 3.0  # standard errors by which held-out error must fall
SURE_FITTED = 2.5  # and that of the fitted logs, whose blocks show whether one moment alone asked for the effect
LEAST = 0.05  # of the held-out square error
WORSE = 3.0  # standard errors by which a regime may not get worse
FEWEST_IN_REGIME = 30


@final
@dataclass(frozen=True)
class Judgement:
    """z: standard errors by which the held-out square error falls; z_fitted: the same in the fitted logs.

    before, after: RMSE of the axis on held-out rows, low-passed [N·m]. blocks: difference of the square error in each
    held-out block, for comparing candidates of one axis with each other. objection: why it may not be claimed, or "".
    """

    score: Score
    z: float
    z_fitted: float
    before: float
    after: float
    blocks: Array
    objection: str

    @property
    def explained(self) -> float:
        """Share of the held-out square error that goes."""
        return 1.0 - (self.after / max(self.before, 1e-300)) ** 2


def judge(model: RobotModel, score: Score, rows: Sequence[AxisRows]) -> Judgement:
    """rows: of the candidate's axis, in all logs."""
    candidate, equations = score.candidate, model.equations
    own = equations.columns()[equations.first_axis + candidate.axis]
    out = [each for each in rows if each.held_out]
    fitted = [each for each in rows if not each.held_out]
    left = {
        id(each): each.after(candidate.effect, candidate.shape, score.coefficients, score.step[own]) for each in rows
    }
    gains, gains_fitted = (
        np.concatenate(
            [_by_block(each.samples, each, each.e**2 - left[id(each)] ** 2) for each in part] or [np.zeros(0)]
        )
        for part in (out, fitted)
    )
    z, z_fitted = _z(gains), _z(gains_fitted)
    before, after = (
        float(np.sqrt(np.mean(np.concatenate(values) ** 2))) if values else float("nan")
        for values in ([each.e for each in out], [left[id(each)] for each in out])
    )
    explained = 1.0 - (after / max(before, 1e-300)) ** 2
    return Judgement(score, z, z_fitted, before, after, gains, _objection(z, z_fitted, explained, gains, out, left))


def apart(one: Judgement, other: Judgement) -> float:
    """Standard errors by which one candidate explains more than another of the same axis, on the same blocks."""
    return _z(one.blocks - other.blocks) if len(one.blocks) == len(other.blocks) else float("nan")


def _objection(
    z: float, z_fitted: float, explained: float, gains: Array, out: Sequence[AxisRows], left: dict[int, Array]
) -> str:
    if len(gains) < FEWEST_BLOCKS:
        return "too little steady motion in logs that were not fitted to judge it"
    if z_fitted < SURE_FITTED:
        return f"one or two moments of the fitted logs alone ask for it ({z_fitted:.1f} standard errors)"
    if explained < LEAST:
        return f"on held-out logs it explains {100 * max(explained, 0.0):.1f} % of the error: not worth a name"
    if z < SURE:
        return f"on held-out logs the error does not fall surely ({z:.1f} standard errors, {SURE:.0f} are asked for)"
    for name, chosen in REGIMES.items():
        inside = [chosen(each) for each in out]
        if sum(int(mask.sum()) for mask in inside) < FEWEST_IN_REGIME:
            continue
        change = [
            _by_block(each.samples[mask], each, (each.e**2 - left[id(each)] ** 2)[mask])
            for each, mask in zip(out, inside, strict=True)
            if mask.any()
        ]
        worse = _z(np.concatenate(change))
        if worse < -WORSE:
            return f"it makes the error larger {name} ({-worse:.1f} standard errors)"
    return ""


def _speed(each: AxisRows) -> Array:
    return np.abs(each.signals.velocity[each.samples]) / max(each.signals.speed_scale, 1e-12)


REGIMES: dict[str, Callable[[AxisRows], NDArray[np.bool_]]] = {
    "at low speed": lambda each: _speed(each) < 0.5,
    "at high speed": lambda each: _speed(each) > 1.2,
    "in positive motion": lambda each: each.signals.velocity[each.samples] > 0.0,
    "in negative motion": lambda each: each.signals.velocity[each.samples] < 0.0,
}


def _by_block(samples: NDArray[np.intp], each: AxisRows, values: Array) -> Array:
    """Sums over blocks of `BLOCK_S` of the log's time."""
    block = np.floor(each.signals.time[samples] / BLOCK_S).astype(np.intp)
    places, number = np.unique(block, return_inverse=True)
    total = np.zeros(len(places))
    np.add.at(total, number, values)
    return total


def _z(gains: Array) -> float:
    """Standard errors by which blocks gain: of their mean, or of their ranks (Wilcoxon) where that says more.

    A few fast blocks that gain much widen the mean's own error; that nearly all blocks gain is just as telling.
    """
    if len(gains) < 2:
        return 0.0
    error = float(gains.std(ddof=1)) / np.sqrt(len(gains))
    mean = float(gains.mean() / error) if error > 0.0 else 0.0
    told = gains[gains != 0.0]
    if len(told) < FEWEST_BLOCKS:
        return mean
    order = rankdata(np.abs(told))
    n = len(told)
    ranks = (float(order[told > 0.0].sum()) - n * (n + 1) / 4.0) / np.sqrt(n * (n + 1) * (2 * n + 1) / 24.0)
    return max(mean, float(ranks)) if mean > 0.0 else min(mean, float(ranks))
