"""Which planned motion a log is of, by its joints' angles alone: where the plan begins in it, and how far it strays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
import scipy
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from exogauge.criteria.following import Following
from exogauge.logs.model import Log

Array = NDArray[np.float64]
ROUNDS = 10  # judgement: Gauss-Newton steps, which end once below a microsecond


@final
@dataclass(frozen=True)
class PlannedSeries:
    """time: (N,) [s] from 0, strictly increasing; q: (N,) [rad or m] by joint."""

    name: str
    time: Array
    q: Mapping[str, Array]

    @property
    def seconds(self) -> float:
        return float(self.time[-1])


@final
@dataclass(frozen=True)
class Stray:
    """How far a joint is from its plan [rad or m]. at_s: of the log, when it is farthest. later_s: [s] than the plan as
    it was placed for all joints; NaN of a joint that does not move in the plan."""

    joint: str
    rms: float
    most: float
    at_s: float
    later_s: float


@final
@dataclass(frozen=True)
class Match:
    """A log beside a plan. plan: its place in the list. begins_s: the log's time at which the plan begins, the robot's
    delay in it. share: rms by which the moving joints stray, of their motion in the plan. covered: share of the plan
    that the log holds. strays: of every joint of the plan that the log has, in the plan's order."""

    plan: int
    begins_s: float
    share: float
    covered: float
    strays: tuple[Stray, ...]


@final
@dataclass(frozen=True)
class Followed:
    """match: with the nearest plan. sure: it is this one; otherwise too far for that, or `rivals` are as near."""

    log: str
    match: Match
    sure: bool
    rivals: tuple[int, ...]


def followed(log: Log, plans: Sequence[PlannedSeries], rules: Following) -> Followed | None:
    """The plan that the log is of; None where it is of none."""
    found = [_matched(log, k, plan, rules) for k, plan in enumerate(plans)]
    near = sorted((each for each in found if each is not None and each.share <= rules.perhaps), key=lambda m: m.share)
    if not near:
        return None
    best, rivals = near[0], tuple(each.plan for each in near[1:] if each.share < rules.nearer * near[0].share)
    return Followed(log.recording, best, best.share <= rules.follows and not rivals, rivals)


def _matched(log: Log, number: int, plan: PlannedSeries, rules: Following) -> Match | None:
    """At the place where it strays least; None where they have no moving joint in common or it is nowhere near."""
    here = [name for name in plan.q if f"q.{name}" in log.channels]
    moving = [name for name in here if np.ptp(plan.q[name]) > rules.moves]
    if not moving or log.samples < 2:
        return None
    t = log.time - log.time[0]
    measured = np.stack([log.channels[f"q.{name}"] for name in here], axis=1)
    columns = [here.index(name) for name in moving]
    wanted = np.stack([plan.q[name] for name in here], axis=1)
    size = float(np.sqrt(np.mean(np.var(wanted[:, columns], axis=0))))
    begin = _place(t, measured[:, columns], plan.time, wanted[:, columns], rules)
    if begin is None or begin[1] > 2.0 * rules.perhaps * size:
        return None  # the coarse grid is off by less than that
    spline = CubicSpline(plan.time, wanted)
    rate, at = spline.derivative(), begin[0]
    for _ in range(ROUNDS):
        inside = (t >= at) & (t <= at + plan.seconds)
        off, slope = measured[inside] - spline(t[inside] - at), rate(t[inside] - at)
        step = -float((off[:, columns] * slope[:, columns]).sum() / max((slope[:, columns] ** 2).sum(), 1e-12))
        at += float(np.clip(step, -1.0 / rules.search_hz, 1.0 / rules.search_hz))
        if abs(step) < 1e-6:
            break
    inside = np.flatnonzero((t >= at) & (t <= at + plan.seconds))
    if len(inside) < 2:
        return None
    off, slope = measured[inside] - spline(t[inside] - at), rate(t[inside] - at)
    farthest = np.abs(off).argmax(axis=0)
    strays = tuple(
        Stray(
            name, float(np.sqrt(np.mean(off[:, j] ** 2))), float(np.abs(off[farthest[j], j])),
            float(log.time[inside[farthest[j]]]),
            -float((off[:, j] * slope[:, j]).sum() / (slope[:, j] ** 2).sum()) if j in columns else float("nan"),
        ) for j, name in enumerate(here)
    )  # fmt: skip
    share = float(np.sqrt(np.mean(off[:, columns] ** 2))) / size
    covered = float((t[inside[-1]] - t[inside[0]]) / plan.seconds)
    return Match(number, float(log.time[0] + at), share, min(covered, 1.0), strays)


def _place(t: Array, measured: Array, time: Array, wanted: Array, rules: Following) -> tuple[float, float] | None:
    """Where on a coarse grid the plan begins [s of t], and the rms by which it strays there; t from 0."""
    grid, own = (np.arange(int(end * rules.search_hz) + 1) / rules.search_hz for end in (t[-1], time[-1]))
    log = np.stack([np.interp(grid, t, column) for column in measured.T], axis=1)
    plan = np.stack([np.interp(own, time, column) for column in wanted.T], axis=1)
    middle = plan.mean(axis=0)
    log, plan = log - middle, plan - middle
    product = np.sum([scipy.signal.correlate(a, b, mode="full") for a, b in zip(log.T, plan.T, strict=True)], axis=0)
    shift = np.arange(len(product)) - (len(plan) - 1)  # of the plan's begin, in samples of the log
    first, last = np.maximum(shift, 0), np.minimum(shift + len(plan), len(log))
    count = last - first
    held = np.flatnonzero(count >= rules.covered * len(plan))
    if not len(held):
        return None

    def sums(values: Array, begin: Array, end: Array) -> Array:
        whole = np.concatenate([[0.0], np.cumsum((values**2).sum(axis=1))])
        return np.asarray(whole[end] - whole[begin])

    apart = sums(log, first, last) + sums(plan, first - shift, last - shift) - 2.0 * product
    rms = np.sqrt(np.maximum(apart[held], 0.0) / (count[held] * plan.shape[1]))
    best = int(rms.argmin())
    return float(shift[held[best]] / rules.search_hz), float(rms[best])
