"""The motion that tells most within every bound: Fourier series, exact gradients, excesses ever dearer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.motion_excite import USUAL, MotionExcite
from exogauge.errors import NotIdentifiable
from exogauge.experiment.information import Information, Told
from exogauge.experiment.series_search import descend, largest_within
from exogauge.robots.motion import Motion
from exogauge.robots.moving.base import BaseTurn
from exogauge.robots.moving.stance import OutOfReachError, Stance, Three
from exogauge.robots.moving.strain import Bounds, Pull
from exogauge.robots.series import Series

Array = NDArray[np.float64]
Report = Callable[[int, int, float, float], None]


@final
@dataclass(frozen=True)
class Task:
    """What is planned, for whom, by which bounds. order: as `Bounds`. home: (free,) where motions are shrunk to."""

    stance: Stance
    series: Series
    information: Information
    bounds: Bounds
    criteria: MotionExcite = USUAL

    @property
    def order(self) -> NDArray[np.intp]:
        return self.bounds.order

    @cached_property
    def home(self) -> Array:
        robot = self.stance.robot
        assert robot.home is not None
        return np.asarray(robot.home[self.stance.free])

    @property
    def home_joints(self) -> Array:
        """(J,) of all joints."""
        robot = self.stance.robot
        assert robot.home is not None
        return np.asarray(robot.home[robot.base :])

    @cached_property
    def sizes(self) -> Array:
        """(free, 1) [rad/s or m/s] speeds that count alike."""
        robot = self.stance.robot
        fast = np.where(np.isfinite(robot.limits.velocity), robot.limits.velocity, 3.0)
        base = np.array([0.1, 0.1, 0.1, 0.5, 0.5, 0.5])[: robot.base]
        return np.asarray(np.concatenate([base, fast])[self.stance.free][:, None])

    @cached_property
    def still(self) -> Array:
        """(free, 2N-2) at home throughout."""
        x = np.zeros((len(self.stance.free), self.series.size))
        x[:, -1] = self.home
        return x

    @cached_property
    def time(self) -> Array:
        count = self.criteria.per_period * self.series.harmonics
        return np.arange(count) * self.series.duration / count

    def motion(self, whole: Three) -> Motion:
        """As the identification sees it."""
        q, v, a = whole
        columns = self.stance.robot.base + self.order
        joints = q[:, columns], v[:, columns], a[:, columns]
        if not self.stance.robot.floating:
            none = np.zeros((len(q), 3))
            return Motion(*joints, np.tile(self._up, (len(q), 1)), none, none)
        return Motion(*joints, *BaseTurn.of(q[:, 3:6], v[:, 3:6], a[:, 3:6]).felt(a[:, :3]))

    @cached_property
    def _up(self) -> Array:
        return -np.asarray(self.stance.robot.model.gravity.linear)

    def told(self, x: Array) -> Told:
        """x: (free, 2N-2)."""
        return self.information.of(
            self.motion(self.stance.whole(*self.series.motion(x, self.time))), self.series.duration
        )

    def largest(self, x: Array, rate_hz: float | None = None) -> tuple[float, str]:
        """Share of the bound that is nearest, at any sample, and which."""
        rate = rate_hz or self.criteria.check_hz
        time = np.arange(round(rate * self.series.duration) + 1) / rate
        return self.largest_of(self.series.motion(x, time))

    def largest_of(self, free: Three) -> tuple[float, str]:
        """The same of the free coordinates' (T, free) u, u̇, ü."""
        return max((share, name) for name, share in self.shares(free).items())

    def shares(self, free: Three) -> dict[str, float]:
        """Of every bound, by name, the largest."""
        try:
            whole = self.stance.whole(*free)
        except OutOfReachError:
            return {"reach of a standing leg": np.inf}
        found = dict[str, float]()
        for part in self.bounds.parts(*whole, self.information.loads(self.motion(whole))):
            for share, name in zip(part.share.max(axis=0), part.names, strict=True):
                found[name] = max(float(share), found.get(name, 0.0))
        return found


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


def random_motion(task: Task, rng: np.random.Generator, share: float = 1.0) -> Array:
    """(free, 2N-2) of random numbers, every joint as large as its own bounds bear, then all together as large
    as the others do; `share` of that. Raises NotIdentifiable where home itself is outside."""
    x = rng.standard_normal(task.still.shape) * task.sizes
    x[:, -1] = task.home
    x = _alone(task, x, rng)
    rest, name = task.largest(task.still, 1.0)
    if rest > 1.0:
        raise NotIdentifiable(f"home is outside a bound while nothing moves ({name}): choose another posture", ())
    rate = len(task.time) / task.series.duration
    most = largest_within(
        lambda part: task.largest(task.still + part * (x - task.still), rate)[0] <= 1.0, task.criteria.halvings
    )
    return task.still + share * most * (x - task.still)


def best_motion(task: Task, rng: np.random.Generator, report: Report | None = None) -> Array:
    """(free, 2N-2) the best of several searches, each from the best of some random motions. Raises NotIdentifiable."""
    found = []
    for k in range(task.criteria.starts):
        drawn = [random_motion(task, rng, 0.8) for _ in range(task.criteria.drawn)]
        start = min(drawn, key=lambda x: task.told(x).cost)
        found.append(improve(task, start, None if report is None else partial(report, k + 1)))
    return min(found, key=lambda x: task.told(x).cost)


def _alone(task: Task, x: Array, rng: np.random.Generator) -> Array:
    """x with every joint as large as its own bounds on position, velocity and acceleration bear, somewhere in its
    range; the base as large as its sizes."""
    joints = task.stance.free >= task.stance.robot.base
    x = x.copy()
    x[:, :-1] /= _shares_of(task, x, task.time)[:, None]
    low, high = _room(task, x, task.time)
    x[joints, -1] += low + rng.uniform(size=len(low)) * (high - low)
    return x


def _shares_of(task: Task, x: Array, time: Array) -> Array:
    """(free,) of a joint's range, speed or acceleration that it would fill by itself; of the base, of its sizes."""
    limits, own = task.stance.robot.limits, task.stance.free - task.stance.robot.base
    joints, own = own >= 0, own[own >= 0]
    u, du, ddu = task.series.motion(x, time)
    share = np.abs(du / task.sizes[:, 0]).max(axis=0)
    for each, size in (
        (np.ptp(u[:, joints], axis=0), limits.upper[own] - limits.lower[own]),
        (np.abs(ddu[:, joints]).max(axis=0), limits.acceleration[own]),
    ):
        share[joints] = np.maximum(share[joints], each / size)
    return np.asarray(share)


def _room(task: Task, x: Array, time: Array) -> tuple[Array, Array]:
    """(joints,) how far each may be moved down and up as a whole until it meets its range."""
    limits, own = task.stance.robot.limits, task.stance.free - task.stance.robot.base
    joints, own = own >= 0, own[own >= 0]
    u = task.series.motion(x, time)[0][:, joints]
    return limits.lower[own] - u.min(axis=0), limits.upper[own] - u.max(axis=0)


def within(task: Task, x: Array) -> Array:
    """As it is, or each joint shrunk and moved into its own bounds, and then all towards home and rest until every
    other bound holds at `check_hz`."""
    rate, tight = task.criteria.check_hz, task.criteria.tight
    time = np.arange(round(rate * task.series.duration) + 1) / rate
    joints, x = task.stance.free >= task.stance.robot.base, x.copy()
    filled = _shares_of(task, x, time)
    x[joints, :-1] *= (tight / np.maximum(filled[joints], tight))[:, None]
    low, high = _room(task, x, time)
    x[joints, -1] += np.clip(0.0, low, high)
    at_rest = task.shares(task.series.motion(task.still, time[:1]))
    for _ in range(task.criteria.shrinks):
        share, name = task.largest(x)
        if share <= 1.0:
            return x
        rest = at_rest.get(name, 0.0)
        kept = tight * (1.0 - rest) / (share - rest) if np.isfinite(share) else 0.0
        x = task.still + min(tight, max(kept, 0.7)) * (x - task.still)
    return x if task.largest(x)[0] <= 1.0 else task.still


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
