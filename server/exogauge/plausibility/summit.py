"""Where a function of one number is largest, by a few of its values."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def summit(x: Array, y: Array) -> float:
    """Of the parabola through three points, the middle one the highest."""
    a, b, _ = np.polyfit(x - x[1], y, 2)
    return float(x[1] - (0.5 * b / a if a < 0.0 else 0.0))


def climb(value: Callable[[float], float], start: float, step: float) -> tuple[float, float]:
    """(the nearest multiple of a step from which no other is higher, where the parabola about it is highest).

    At most half a turn of steps, which brings an angle to where it has been.
    """
    known, at = cache(value), start
    step = step if known(start + step) > known(start) else -step
    for _ in range(int(np.pi / abs(step))):
        if known(at + step) <= known(at):
            break
        at += step
    three = np.array([at - abs(step), at, at + abs(step)])
    return at, summit(three, np.array([known(float(each)) for each in three]))
