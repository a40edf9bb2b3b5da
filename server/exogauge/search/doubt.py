"""How well an effect's numbers are known: coefficients and shapes together, the baseline fitted beside them.

What is worth a name: it matters beside the sensors' noise, and is no part of what was named at its place.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.searching import Searching
from exogauge.devices.result import Estimate
from exogauge.findings.verdict import Objection, Why
from exogauge.identification.model import Effect, RobotModel
from exogauge.search.score import Score, residual_memory
from exogauge.search.site_rows import SiteRows
from exogauge.search.sums import KindSums

Array = NDArray[np.float64]


def parameters(model: RobotModel, found: Score, rows: Sequence[SiteRows]) -> Mapping[str, Estimate]:
    """Name -> value, standard deviation, unit; shapes in units of the axis are given in SI units. Without those that
    make no difference here, such as one that asks for a thermometer where there is none."""
    candidate, effect = found.candidate, found.candidate.effect
    weights, own = model.solution.weights, model.equations.columns()
    fitted = [each for each in rows if not each.held_out]
    total: dict[int, KindSums] = {}
    square, memories, count = 0.0, list[float](), 0
    for each in fitted:
        columns = each.columns(effect, candidate.shape)
        left = each.after(columns, found.coefficients, found.step, own)
        slopes = [
            columns,
            *shape_slopes(effect, candidate.shape, found.coefficients, each),
        ]
        for kind, e in left.items():
            if weights[kind] > 0.0:
                c = np.hstack([one[kind] for one in slopes])
                total.setdefault(kind, KindSums.empty(c.shape[1], each.rows[kind].A.shape[1])).add(
                    each.rows[kind].A, c, e
                )
                square, count = square + weights[kind] * float(e @ e), count + len(e)
                memories.append(residual_memory(e))
    size = candidate.width + len(_free(found))
    B, S = np.zeros((model.equations.size, size)), np.zeros((size, size))
    for kind, sums in total.items():
        B[own[kind]] += weights[kind] * sums.cross.T
        S += weights[kind] * sums.own
    squares = np.diag(S).copy()
    scale = float(np.median(memories)) * square / max(count, 1)
    std = np.sqrt(np.diag(inverse_of_rest(S, B.T @ model.solution.unbounded.divided(B))) * scale)
    names = [*(each.name for each in effect.coefficients), *_free(found)]
    doubt = dict(zip(names, std, strict=True))
    idle = {name for name, own_square in zip(names, squares, strict=True) if own_square == 0.0 and name in _free(found)}
    named = [(each.name, each.unit) for each in effect.coefficients] + [(one.name, one.unit) for one in effect.shapes]
    estimates = {}
    for (name, own_unit), value in zip(named, [*found.coefficients, *candidate.shape], strict=True):
        if name in idle:
            continue
        factor, unit = candidate.site.in_si(model, own_unit, candidate.shape)
        estimates[name] = Estimate(float(value) * factor, float(doubt.get(name, 0.0)) * factor, unit)
    return estimates


def inverse_of_rest(squares: Array, taken: Array) -> Array:
    """(C, C) inverse of what is left of columns, squares - taken, once all that is fitted beside them is out.

    squares and taken are of the same rows, so what is left is zero at least. No direction is known better than by
    `resolved` of its square: rounding. What was left of one that is swallowed came out below zero, and its doubt as
    none. Columns of zeros have none.
    """
    resolved = 1e-9
    size = np.sqrt(np.diag(squares))
    live = np.flatnonzero(size > 0.0)
    unit = np.outer(size[live], size[live])
    left, ways = np.linalg.eigh((squares - taken)[np.ix_(live, live)] / unit)
    inverse = np.zeros_like(squares)
    inverse[np.ix_(live, live)] = (ways / np.maximum(left, resolved)) @ ways.T / unit
    return inverse


def _free(found: Score) -> list[str]:
    """Shapes that are not a choice."""
    return [one.name for one in found.candidate.effect.shapes if not one.choice]


def shape_slopes(
    effect: Effect, shape: tuple[float, ...], coefficients: Array, rows: SiteRows
) -> list[Mapping[int, Array]]:
    """Per free shape: kind -> (n, 1) change of what the effect takes off the row with it."""
    slopes: list[Mapping[int, Array]] = []
    for k, (value, one) in enumerate(zip(shape, effect.shapes, strict=True)):
        if one.choice:
            continue
        step = 0.02 * (abs(value) or one.high - one.low)
        low, high = max(value - step, one.low), min(value + step, one.high)
        below, above = (rows.columns(effect, (*shape[:k], end, *shape[k + 1 :])) for end in (low, high))
        slopes.append({kind: ((above[kind] - below[kind]) @ coefficients / (high - low))[:, None] for kind in above})
    return slopes


def gone(before: float, after: float) -> float:
    """RMS that goes with an effect; before, after: RMSE without and with it."""
    return float(np.sqrt(max(before**2 - after**2, 0.0)))


@final
@dataclass(frozen=True)
class Named:
    """An effect at the same place, and the RMS that it took off. same_curve: it depends on the same coordinate."""

    effect: str
    took: float
    same_curve: bool


def not_worth(size: float, floor: float, named: Sequence[Named], criteria: Searching) -> Objection | None:
    """Why an effect that takes this much off the held-out error is not worth a name. floor: of the same channel."""
    if size < criteria.matters * floor:
        return Objection(Why.TOO_SMALL, size, floor)
    for each in named:
        if size < (criteria.of_the_curve if each.same_curve else criteria.remainder) * each.took:
            return Objection(Why.SMALL_BESIDE, of=(each.effect,))
    return None
