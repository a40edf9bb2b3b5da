"""How many samples of each kind of row count as one: residuals are coloured, and more so where more is missing."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.model import RobotModel
from exogauge.logs.model import Log
from exogauge.search.score import residual_memory

Array = NDArray[np.float64]


def row_memory(model: RobotModel, logs: Sequence[Log]) -> Array:
    """(rows,) as many as its residual remembers, in the median log; at rest as in steady motion."""
    equations, x = model.equations, model.solution.unbounded.x
    of_logs = []
    for log in logs:
        prepared = model.prepare(log)
        residual = equations.residuals(prepared, x)
        steady = equations.layout.axes
        residual[:, steady][~prepared.steady[prepared.kept]] = np.nan
        of_logs.append([residual_memory(each) for each in residual.T])
    return np.maximum(np.median(of_logs, axis=0), model.criteria.search.least_memory)
