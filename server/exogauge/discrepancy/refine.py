"""Shapes between the values of a grid: those with which the candidate explains most of the fitted logs."""

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
    if not shapes or any(one.choice for one in shapes):
        return first

    def at(values: Array) -> Score | None:
        shape = tuple(_value(u, one) for u, one in zip(values, shapes, strict=True))
        moved = replace(candidate, shape=shape)
        return score(model, moved, sums_of(rows, candidate.effect, shape), memory)

    def cost(values: Array) -> float:
        found = at(np.clip(values, 0.0, 1.0))
        return 0.0 if found is None else -found.gain

    start = np.array([_unit(value, one) for value, one in zip(candidate.shape, shapes, strict=True)])
    simplex = np.vstack(
        [start, *(start + (0.08 if u < 0.9 else -0.08) * np.eye(len(start))[k] for k, u in enumerate(start))]
    )
    best = minimize(
        cost, start, method="Nelder-Mead", options={"maxfev": TRIALS * len(shapes), "initial_simplex": simplex,
                                                    "xatol": 0.01, "fatol": 1e-3 * first.gain},
    )  # fmt: skip
    found = at(np.clip(best.x, 0.0, 1.0))
    return found if found is not None and found.gain > first.gain else first


def _unit(value: float, shape: Shape) -> float:
    """0…1 between the bounds; in logarithms where both are positive."""
    if shape.low > 0.0:
        return float(np.log(value / shape.low) / np.log(shape.high / shape.low))
    return (value - shape.low) / (shape.high - shape.low)


def _value(unit: float, shape: Shape) -> float:
    if shape.low > 0.0:
        return float(shape.low * (shape.high / shape.low) ** unit)
    return float(shape.low + unit * (shape.high - shape.low))
