"""Shapes between the values of a grid: those with which the candidate explains most of the fitted logs.

Near a shape that the baseline swallows the predicted gain is all rounding; the evidence, which counts what the rows
really gain, falls there, and the search turns back.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from exogauge.discrepancy.score import Score, score
from exogauge.discrepancy.site_rows import SiteRows, sums_of
from exogauge.effects.shaped import Shape
from exogauge.identification.model import RobotModel

Array = NDArray[np.float64]

TRIALS = 40  # of the search, per shape


def refined(model: RobotModel, first: Score, rows: Sequence[SiteRows], memory: Mapping[int, float]) -> Score:
    """The candidate with its shapes searched from the grid's best, within their bounds."""
    candidate = first.candidate
    shapes = candidate.effect.shapes
    free = [k for k, one in enumerate(shapes) if not one.choice]
    if not free:
        return first

    def at(values: Array) -> Score | None:
        shape = list(candidate.shape)
        for k, u in zip(free, values, strict=True):
            shape[k] = _value(u, shapes[k])
        sums = sums_of(rows, candidate.effect, tuple(shape))
        return score(model, replace(candidate, shape=tuple(shape)), sums, memory)

    def cost(values: Array) -> float:
        found = at(np.clip(values, 0.0, 1.0))
        return 0.0 if found is None or found.evidence < first.evidence else -found.gain

    start = np.array([_unit(candidate.shape[k], shapes[k]) for k in free])
    simplex = np.vstack(
        [start, *(start + (0.08 if u < 0.9 else -0.08) * np.eye(len(start))[k] for k, u in enumerate(start))]
    )
    best = minimize(
        cost, start, method="Nelder-Mead", options={"maxfev": TRIALS * len(free), "initial_simplex": simplex,
                                                    "xatol": 0.01, "fatol": 1e-3 * first.gain},
    )  # fmt: skip
    found = at(np.clip(best.x, 0.0, 1.0))
    better = found is not None and found.evidence >= first.evidence and found.gain > first.gain
    return found if found is not None and better else first


def _unit(value: float, shape: Shape) -> float:
    """0…1 between the bounds; in logarithms where both are positive."""
    if shape.low > 0.0:
        return float(np.log(value / shape.low) / np.log(shape.high / shape.low))
    return (value - shape.low) / (shape.high - shape.low)


def _value(unit: float, shape: Shape) -> float:
    if shape.low > 0.0:
        return float(shape.low * (shape.high / shape.low) ** unit)
    return float(shape.low + unit * (shape.high - shape.low))
