"""The search for the numbers of a series whose motion tells most, within bounds: what every planner of one shares."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

Array = NDArray[np.float64]


def descend(point: Callable[[Array, float], tuple[float, Array]], x: Array, scale: Array, costs: Sequence[float],
            steps: int) -> Array:  # fmt: skip
    """The numbers near x of least cost, by L-BFGS: excesses of bounds are squared and ever dearer.

    point: (x, dear) -> cost with excesses at that price, and its gradient. scale: as x, sizes that count alike. steps:
    how often the motion is computed at each of `costs`, at most.
    """
    y = (x / scale).ravel()

    def at(y: Array, dear: float) -> tuple[float, Array]:
        cost, gradient = point(y.reshape(x.shape) * scale, dear)
        return cost, (gradient * scale).ravel()

    for dear in costs:
        y = minimize(at, y, (dear,), jac=True, method="L-BFGS-B", options={"maxfun": steps, "maxcor": 20}).x
    return np.asarray(y).reshape(x.shape) * scale


def largest_within(inside: Callable[[float], bool], halvings: int) -> float:
    """The largest share of a motion that keeps within its bounds, more than all of it where they bear that; nothing of
    it does."""
    low, high = 0.0, 1.0
    while inside(high):
        low, high = high, 2.0 * high
    return _between(inside, low, high, halvings)


def part_within(inside: Callable[[float], bool], halvings: int) -> float:
    """The largest share that keeps within them of a motion that does not."""
    return _between(inside, 0.0, 1.0, halvings)


def _between(inside: Callable[[float], bool], low: float, high: float, halvings: int) -> float:
    for _ in range(halvings):
        middle = (low + high) / 2
        low, high = (middle, high) if inside(middle) else (low, middle)
    return low
