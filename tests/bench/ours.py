"""Our way: only the non-zero rows, batched over time, reduced to sufficient statistics as they come."""

from __future__ import annotations

import numpy as np
import scipy.linalg as sl
from numpy.typing import NDArray
from tests.bench.problems import Problem, parts

from exogauge.estimation.statistics import Statistics
from exogauge.robots.row_blocks import RowBlocks

Array = NDArray[np.float64]

BATCH = 400_000  # numbers per batch, 3 MB: 200 samples of Talos, 1000 of an arm


def rows_of(problem: Problem) -> RowBlocks:
    return RowBlocks(problem.tree, problem.base, np.eye(len(problem.tree.joints)))


def chunk(rows: RowBlocks) -> int:
    """Samples per batch."""
    return int(np.clip(BATCH // sum(len(columns) + 1 for columns in rows.columns), 100, 1000))


def fill_only(problem: Problem, rows: RowBlocks) -> None:
    """The blocks alone, thrown away."""
    blocks = None
    for part in parts(problem.samples, chunk(rows)):
        blocks = rows.fill(problem.motion.rows(part), 1, blocks)


def gather(problem: Problem, rows: RowBlocks) -> Statistics:
    """One pass over the log."""
    statistics = Statistics.empty(len(problem.base.columns), rows.columns)
    blocks = None
    for part in parts(problem.samples, chunk(rows)):
        blocks = rows.fill(problem.motion.rows(part), 1, blocks)
        for kind, block in enumerate(blocks):
            block[:, -1] = problem.forces[part, kind]
            statistics.add_rows(kind, block)
    return statistics


def solve(statistics: Statistics) -> Array:
    """(B,) ordinary least squares: every row counts alike."""
    root = statistics.square_root(np.ones(len(statistics.columns)))
    Q, upper = sl.qr(root.R, mode="economic")
    return np.asarray(sl.solve_triangular(upper, Q.T @ root.z))


def identify(problem: Problem, rows: RowBlocks) -> Array:
    """(B,) from the log to the estimate."""
    return solve(gather(problem, rows))
