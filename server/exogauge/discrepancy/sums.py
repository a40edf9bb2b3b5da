"""What candidates need of the data: sums of products of their columns with the model's and with the residual.

One pass over each log; afterwards a candidate costs a small solve, however long the logs are.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.equations import Equations
from exogauge.identification.preparation import Prepared

Array = NDArray[np.float64]


@final
@dataclass
class AxisSums:
    """Steady rows of one axis, k parameters, C candidate columns c (torque delivered, so that the row holds -c).

    cross: (C, k) Σ -c a^T. own: (C, C) Σ c c^T. with_residual: (C,) Σ -c e. square: Σ e². rows: how many.
    """

    cross: Array
    own: Array
    with_residual: Array
    square: float = 0.0
    rows: int = 0

    @staticmethod
    def empty(columns: int, parameters: int) -> AxisSums:
        return AxisSums(np.zeros((columns, parameters)), np.zeros((columns, columns)), np.zeros(columns))

    def add(self, A: Array, c: Array, e: Array) -> None:
        """A: (n, k). c: (n, C). e: (n,) y - A x."""
        self.cross -= c.T @ A
        self.own += c.T @ c
        self.with_residual -= c.T @ e
        self.square += float(e @ e)
        self.rows += len(e)

    def part(self, which: slice) -> AxisSums:
        """Of some of the columns."""
        return AxisSums(self.cross[which], self.own[which, which], self.with_residual[which], self.square, self.rows)


@final
@dataclass
class Sums:
    """by_axis: axis -> sums over all logs taken in."""

    by_axis: dict[int, AxisSums] = field(default_factory=dict)

    def take(self, equations: Equations, prepared: Prepared, x: Array, columns: Mapping[int, Array]) -> Array:
        """Add one log; its residuals (n_kept, A), NaN where an axis gives no row.

        x: (P,). columns: axis -> (n_kept, C) candidate torques.
        """
        kinds, axes = equations.columns(), len(equations.robot.joints)
        residuals = np.full((len(prepared.kept), axes), np.nan)
        for _, chunks in equations.rows(prepared, x):
            for chunk in chunks:
                axis = chunk.kind - equations.first_axis
                if axis in columns and 0 <= axis < axes:
                    A, y = chunk.block[:, :-1], chunk.block[:, -1]
                    e = y - A @ x[kinds[chunk.kind]]
                    residuals[chunk.samples, axis] = e
                    sums = self.by_axis.setdefault(axis, AxisSums.empty(columns[axis].shape[1], A.shape[1]))
                    sums.add(A, columns[axis][chunk.samples], e)
        return residuals
