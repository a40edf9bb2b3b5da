"""What the service computes: currents, friction, two foot sensors; CSV to estimate; what comes after the one pass."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import final

import numpy as np
import pyarrow as pa
import pyarrow.csv
from numpy.typing import NDArray
from tests.bench.problems import Problem
from tests.bench.study import CUTOFF_HZ, equations_of, log_of
from tests.bench.timing import in_turns, seconds_of

from exogauge.estimation.least_squares import PriorLeastSquares
from exogauge.estimation.statistics import Statistics
from exogauge.identification.equations import Equations
from exogauge.identification.preparation import Prepared, prepare
from exogauge.identification.prior import per_parameter, scales
from exogauge.identification.turns import rest_detection
from exogauge.logs.reading import read_log

Array = NDArray[np.float64]

ITERATIONS = 5  # of re-weighting, to the estimate


@final
@dataclass
class Product:
    """parameters: unknowns. rate: samples per CPU second of the pass. iteration_ms: one IRLS iteration."""

    parameters: int
    rate: float
    iteration_ms: float


def measure(problem: Problem, repeats: int) -> Product:
    equations, prepared = equations_of(problem)
    prepared = replace(prepared, kept=np.arange(problem.samples))
    x = np.zeros(equations.size)
    statistics = equations.collect(prepared, x, folds=1)[0]
    rivals = {
        "pass": seconds_of(lambda: equations.collect(prepared, x, folds=1)),
        "iteration": seconds_of(_iteration(equations, prepared, statistics)),
    }
    seconds = in_turns(rivals, repeats)
    return Product(equations.size, problem.samples / seconds["pass"], 1e3 * seconds["iteration"])


def _iteration(equations: Equations, prepared: Prepared, statistics: Statistics) -> Callable[[], Array]:
    """Weights from residuals, solution: once."""
    prior = per_parameter(equations.robot, equations.base, equations.effects, scales(equations.robot, [prepared]))
    x = prior.seen_mean

    def iterate() -> Array:
        nonlocal x
        left = statistics.residual_square_sum(x)  # a kind of row that this log lacks has none and weighs nothing
        weights = np.divide(statistics.count, left, out=np.zeros_like(left), where=left > 0.0)
        x = PriorLeastSquares(statistics.square_root(weights), prior, 1.0).x
        return x

    return iterate


def from_csv(problem: Problem, width: int, folder: Path) -> dict[str, float]:
    """CPU seconds by stage from a CSV of `width` columns to the estimate.

    The pass is taken with every sample and with the samples that the low-pass leaves (`decimated pass`).
    """
    file = folder / "log.csv"
    log = log_of(problem)
    columns = {"t": log.time, **log.channels}
    spare = [f"{kind}.{name}" for kind in ("dq", "temp") for name in problem.tree.joints]
    columns |= {name: problem.motion.dq[:, k % problem.motion.dq.shape[1]] for k, name in enumerate(spare)}
    pyarrow.csv.write_csv(pa.table(dict(list(columns.items())[:width])), file)
    equations, _ = equations_of(problem.first(1000))
    x, robot, seconds, clock = np.zeros(equations.size), equations.robot, dict[str, float](), time.process_time
    start = clock()
    read = read_log(file, "log")
    seconds["read"] = clock() - start
    start = clock()
    prepared = prepare(robot, read, CUTOFF_HZ, rest_detection(robot, [read], CUTOFF_HZ))
    seconds["filter, differentiate"] = clock() - start
    start = clock()
    equations.collect(replace(prepared, kept=np.arange(read.samples)), x, folds=4)
    seconds["pass over every sample"] = clock() - start
    start = clock()
    total = equations.collect(prepared, x, folds=1)[0]
    seconds["pass, decimated"] = clock() - start
    start = clock()
    iterate = _iteration(equations, prepared, total)
    for _ in range(ITERATIONS):
        iterate()
    seconds["weights and solution"] = clock() - start
    file.unlink()
    return seconds
