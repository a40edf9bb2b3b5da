"""Rigid body, zero and inclination beside what was named: one weighted least-squares problem, and one more effect."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
import scipy
from numpy.typing import NDArray

from exogauge.criteria.criteria import Criteria
from exogauge.payload.missing.effect import Effect, Frame
from exogauge.payload.missing.stretch import Stretch

Array = NDArray[np.float64]

SIZE = 18  # [m, m c, I, F_0, turn of gravity about x and y of the base]
LOOSE = np.array([1e3, *[1e3] * 3, *[1e3] * 6, *[1e4] * 6])  # std of what is not known before: beyond any payload
TILT = np.radians(10.0)  # std of a turn that is sought at all


@final
@dataclass(frozen=True)
class Named:
    """An effect with the shape that it has."""

    effect: Effect
    shape: tuple[float, ...]


@final
@dataclass(frozen=True)
class Fitted:
    """x: (18 + P,) of the body, then of what was named. covariance: of it, samples counted by their memory. rss: of
    rows in units of their floors, counted so too; rows: as many. root: (N, 18 + P) orthonormal; residual: (N,)."""

    x: Array
    covariance: Array
    rss: float
    rows: float
    root: Array
    triangle: Array
    residual: Array


@final
@dataclass(frozen=True)
class Problem:
    """stretches: what is fitted. frame: of the columns. inclined: whether the base's inclination is a parameter.
    criteria: what decides. known: whether body and zero are, so that nothing of them is fitted."""

    stretches: Sequence[Stretch]
    frame: Frame
    inclined: bool
    criteria: Criteria
    known: bool = False

    def at(self, body: Array) -> Problem:
        return replace(self, frame=replace(self.frame, body=body))

    def coarse(self) -> Problem:
        """Some of the samples: enough to choose a shape by."""
        every = 5  # sample of a motion, where shapes are chosen
        kept = [each if each.still else each.using(np.arange(len(each.wrench)) % every == 0) for each in self.stretches]
        return self.of(kept)

    def slow(self) -> Problem:
        """Means over a fifth of a second: what errors of smoothed accelerations, which are faster, hardly reach."""
        return self.of([each if each.still else each.slow(self.criteria.payload.slow_s) for each in self.stretches])

    def of(self, stretches: Sequence[Stretch]) -> Problem:
        return replace(self, stretches=stretches)


def fit(problem: Problem, named: Sequence[Named]) -> Fitted:
    level = 1e-9  # kg, N, rad: of what is not sought
    Z, y = stacked(problem, named)
    prior = np.zeros((SIZE, Z.shape[1]))
    loose = np.append(LOOSE, [TILT if problem.inclined else level] * 2)
    np.fill_diagonal(prior, 1.0 / np.minimum(loose, level if problem.known else np.inf))
    root, R = np.linalg.qr(np.vstack([Z, prior]))
    goal = np.append(y, np.zeros(SIZE))
    x = np.linalg.solve(R, root.T @ goal)
    residual = goal - root @ (root.T @ goal)
    inverse = np.linalg.inv(R)
    return Fitted(x, inverse @ inverse.T, float(residual @ residual), counted(problem.stretches), root, R, residual)


def left_with(
    problem: Problem, named: Sequence[Named], fitted: Fitted, effect: Effect, shape: Sequence[float]
) -> Array:
    """(N,) what is left of the rows with one effect more, the body fitted again beside it."""
    swallowed = 1e-6  # of a column's square: what is left of less beside the body says nothing
    if effect.retimed:
        return fit(problem, [*named, Named(effect, tuple(shape))]).residual
    C = np.vstack([weighted(each, _late(effect.columns(problem.frame, each, shape), each, named))
                   for each in problem.stretches])  # fmt: skip
    C = np.vstack([C, np.zeros((SIZE, C.shape[1]))])
    before = np.sum(C**2, axis=0)
    C = C - fitted.root @ (fitted.root.T @ C)
    if effect.unit:
        return np.asarray(fitted.residual - C[:, 0])
    C = C[:, np.sum(C**2, axis=0) > swallowed * before]
    if not C.shape[1]:
        return fitted.residual
    C = C / np.linalg.norm(C, axis=0)
    found, *_ = np.linalg.lstsq(C.T @ C, C.T @ fitted.residual, rcond=swallowed)
    return np.asarray(fitted.residual - C @ found)


def with_best_shape(
    problem: Problem, named: Sequence[Named], fitted: Fitted, effect: Effect,
    starts: Sequence[Sequence[float]], near: float = 0.1,
) -> Named:  # fmt: skip
    """The shape that leaves least, from the best of some starts. near: how far it is looked for, in shares of a range
    where there is but one."""
    trials = 40  # of the search for a shape, per shape
    if not effect.bounds:
        return Named(effect, ())
    low, high = np.array(effect.bounds).T

    def cost(shape: Sequence[float]) -> float:
        return float(np.sum(left_with(problem, named, fitted, effect, shape) ** 2))

    def at(u: Array) -> tuple[float, ...]:
        return tuple(float(each) for each in low + np.clip(u, 0.0, 1.0) * (high - low))

    start = (np.array(min(starts, key=cost) if len(starts) > 1 else starts[0]) - low) / (high - low)
    if len(start) == 1:  # it may jump, as where a step is moved
        ends = np.clip(start[0] + np.array([-near, near]), 0.0, 1.0)

        def along(u: float) -> float:
            return cost(at(np.array([u])))

        only = scipy.optimize.minimize_scalar(along, bounds=ends, method="bounded",
                               options={"maxiter": trials, "xatol": 1e-2 * near})  # fmt: skip
        return Named(effect, at(np.array([only.x])))

    def left(u: Array) -> Array:
        return left_with(problem, named, fitted, effect, at(u))

    several = scipy.optimize.least_squares(
        left, np.clip(start, 1e-3, 1.0 - 1e-3),
        bounds=(0.0, 1.0), max_nfev=trials, xtol=1e-4, ftol=1e-5,
    )  # fmt: skip
    return Named(effect, at(several.x))


def in_floors(problem: Problem, residual: Array) -> list[Array]:
    """(T', 6) per stretch, of the samples that count, from (N,)."""
    counts = [6 * int(np.count_nonzero(each.use)) for each in problem.stretches]
    parts = np.split(residual[: sum(counts)], np.cumsum(counts)[:-1])
    return [part.reshape(-1, 6) * np.sqrt(each.memory) for part, each in zip(parts, problem.stretches, strict=True)]


def stacked(problem: Problem, named: Sequence[Named]) -> tuple[Array, Array]:
    """(N, 18 + P) and (N,), divided by floors and by the root of the memory."""
    rows = [weighted(each, design(problem.frame, each, named)) for each in problem.stretches]
    goal = [weighted(each, _beyond(problem.frame, each, named)[:, :, None]) for each in problem.stretches]
    return np.vstack(rows), np.vstack(goal)[:, 0]


def design(frame: Frame, stretch: Stretch, named: Sequence[Named]) -> Array:
    """(T, 6, 18 + P)"""
    T = len(stretch.wrench)
    parts = [stretch.rigid, np.broadcast_to(np.eye(6), (T, 6, 6)), frame.tilting(stretch)]
    parts += [each.effect.columns(frame, stretch, each.shape) for each in named if not each.effect.unit]
    return _late(np.concatenate(parts, axis=2), stretch, named)


def residuals(frame: Frame, stretch: Stretch, named: Sequence[Named], x: Array) -> Array:
    """(T, 6) [N, N·m]; x: (18 + P,)."""
    return np.asarray(_beyond(frame, stretch, named) - design(frame, stretch, named) @ x)


def _beyond(frame: Frame, stretch: Stretch, named: Sequence[Named]) -> Array:
    """(T, 6) the wrench without what has a coefficient of 1."""
    units = [each.effect.columns(frame, stretch, each.shape) for each in named if each.effect.unit]
    if not units:
        return stretch.wrench
    return np.asarray(stretch.wrench - _late(np.sum(units, axis=0), stretch, named)[:, :, 0])


def counted(stretches: Sequence[Stretch]) -> float:
    """Rows, as many as count."""
    return float(sum(6 * np.count_nonzero(each.use) / max(each.memory, each.block) for each in stretches))


def weighted(stretch: Stretch, values: Array) -> Array:
    """(T, 6, K) -> (6 T', K) of the samples that count."""
    rows, n = values[stretch.use], stretch.block
    if n > 1:
        rows = rows[: len(rows) // n * n].reshape(-1, n, *rows.shape[1:]).mean(axis=1) * np.sqrt(n)
    scaled = rows / (stretch.floor * np.sqrt(stretch.memory))[:, None]
    return np.asarray(scaled.reshape(-1, values.shape[2]))


def _late(columns: Array, stretch: Stretch, named: Sequence[Named]) -> Array:
    """What a wrench that is late reads. Beyond the log's begin it is held."""
    seconds = sum(each.shape[0] for each in named if each.effect.retimed)
    if seconds == 0.0 or stretch.still:
        return columns
    at = np.clip(stretch.time - seconds, stretch.time[0], stretch.time[-1])
    return np.asarray(scipy.interpolate.CubicSpline(stretch.time, columns)(at))
