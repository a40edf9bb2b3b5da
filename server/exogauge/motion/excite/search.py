"""The motion that tells most within every bound: Fourier series, exact gradients, excesses ever dearer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.experiment.envelope import Envelope, random_motion, within
from exogauge.experiment.information import Information, Told
from exogauge.experiment.series_search import descend
from exogauge.robots.motion import Motion
from exogauge.robots.moving.base import BaseTurn
from exogauge.robots.moving.stance import OutOfReachError
from exogauge.robots.moving.strain import Pull

Array = NDArray[np.float64]
Report = Callable[[int, int, float, float], None]


@final
@dataclass(frozen=True)
class Task(Envelope):
    """What is planned, for whom, by which bounds, and what it will tell."""

    information: Information = field(kw_only=True)

    def loads(self, motion: Motion) -> Array:
        return self.information.loads(motion)

    def told(self, x: Array) -> Told:
        """x: (free, 2N-2)."""
        return self.information.of(
            self.motion(self.stance.whole(*self.series.motion(x, self.time))), self.series.duration
        )


def point(task: Task, x: Array, dear: float) -> tuple[float, Array, float]:
    """Cost with excesses, its gradient (free, 2N-2), and the largest share."""
    columns = task.series.columns(task.time)
    try:
        whole = task.stance.whole(*np.einsum("ktp,np->ktn", columns, x))
    except OutOfReachError:
        return task.criteria.out, np.zeros_like(x), np.inf
    told = task.information.of(task.motion(whole), task.series.duration)
    T, n = whole[0].shape
    pull = Pull.none(T, n, told.loads.shape[1])
    cost, largest = told.cost, 0.0
    for part in task.bounds.parts(*whole, told.loads):
        excess = np.maximum(part.share - task.criteria.kept, 0.0)
        cost += dear * float(np.sum(excess**2)) / T
        largest = max(largest, float(part.share.max(initial=0.0)))
        part.pull(2.0 * dear / T * excess, pull)
    by = told.slopes(loads=pull.loads)
    joints = task.stance.robot.base + task.order
    for at, slopes in ((pull.q, by.q), (pull.v, by.dq), (pull.a, by.ddq)):
        at[:, joints] += slopes
    if task.stance.robot.floating:
        q, v, a = whole
        base = BaseTurn.of(q[:, 3:6], v[:, 3:6], a[:, 3:6]).back(a[:, :3], by.acc, by.gyro, by.gyro_dot)
        for at, slopes in zip((pull.q, pull.v, pull.a), base, strict=True):
            at[:, :6] += slopes
    free = task.stance.back(whole, (pull.q, pull.v, pull.a))
    return cost, np.asarray(np.einsum("ktp,ktn->np", columns, np.stack(free))), largest


def best_motion(task: Task, rng: np.random.Generator, report: Report | None = None) -> Array:
    """(free, 2N-2) the best of several searches, each from the best of some random motions. Raises NotIdentifiable."""
    found = []
    for k in range(task.criteria.starts):
        drawn = [random_motion(task, rng, 0.8) for _ in range(task.criteria.drawn)]
        start = min(drawn, key=lambda x: task.told(x).cost)
        found.append(improve(task, start, None if report is None else partial(report, k + 1)))
    return min(found, key=lambda x: task.told(x).cost)


def improve(task: Task, x: Array, report: Callable[[int, float, float], None] | None = None) -> Array:
    """From a start x (free, 2N-2): the motion of least cost near it, within all bounds.

    report: told how often the motion was computed, its cost and the largest share of a bound.
    """
    scale = np.tile(task.sizes, (1, task.series.size))
    evaluations = 0

    def at(x: Array, dear: float) -> tuple[float, Array]:
        nonlocal evaluations
        evaluations += 1
        cost, gradient, largest = point(task, x, dear)
        if report is not None:
            report(evaluations, cost, largest)
        return cost, gradient

    return within(task, descend(at, x, scale, task.criteria.costs, task.criteria.steps))
