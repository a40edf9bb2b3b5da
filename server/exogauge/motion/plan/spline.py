"""The trajectory that is planned: a uniform cubic B-spline."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, final

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline

Array = NDArray[np.float64]


class Trajectory(Protocol):
    """duration: [s]."""

    @property
    def duration(self) -> float: ...

    def at(self, time: Array) -> tuple[Array, Array, Array]:
        """q, q̇, q̈ (T, n) at times (T,) from 0 to `duration`."""
        ...


@final
@dataclass(frozen=True)
class Spline:
    """control: (N + 2, n), step: [s] between the N nodes; node k is where control point k + 1 weighs most.

    Inside the range of the control points, its rate inside that of (c₊ - c) / step, its acceleration inside that of
    the nodes: bounds on these hold between nodes too.
    """

    control: Array
    step: float

    @property
    def duration(self) -> float:
        """[s]"""
        return (len(self.control) - 3) * self.step

    def at_nodes(self) -> tuple[Array, Array, Array]:
        """q, q̇, q̈ (N, n)."""
        before, here, after = self.control[:-2], self.control[1:-1], self.control[2:]
        h = self.step
        return (before + 4.0 * here + after) / 6.0, (after - before) / (2.0 * h), (after - 2.0 * here + before) / h**2

    def at(self, time: Array) -> tuple[Array, Array, Array]:
        """q, q̇, q̈ (T, n) at times (T,) from 0 to `duration`."""
        count = len(self.control)
        whole = BSpline(self.step * (np.arange(count + 4) - 3.0), self.control, 3)
        return whole(time), whole(time, 1), whole(time, 2)

    def refined(self, count: int) -> Spline:
        """The same trajectory with `count` nodes in place of one; count: a power of two."""
        control, step = self.control, self.step
        while count > 1:
            fine = np.empty((2 * len(control) - 3, control.shape[1]))
            fine[1::2] = (control[:-2] + 6.0 * control[1:-1] + control[2:]) / 8.0
            fine[::2] = 0.5 * (control[:-1] + control[1:])
            control, step, count = fine, 0.5 * step, count // 2
        return Spline(control, step)


def controls_of(q: Array, v: Array, a: Array, step: float) -> Array:
    """(3, n) control points of a node with q, q̇, q̈ (n,)."""
    middle = q - a * step**2 / 6.0
    half = 0.5 * a * step**2
    return np.stack([middle + half - v * step, middle, middle + half + v * step])


def through(nodes: Array, step: float) -> Spline:
    """The smooth spline near nodes (N, n) that rests at both ends."""
    control = np.concatenate([nodes[:1], nodes, nodes[-1:]])
    control[2], control[-3] = control[0], control[-1]
    return Spline(control, step)
