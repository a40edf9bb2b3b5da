"""How well what was found is known: shapes beside coefficients and body, by first order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from exogauge.payload.dynamics import correlation_time
from exogauge.payload.missing.effect import Effect
from exogauge.payload.missing.fit import (
    SIZE,
    Fitted,
    Named,
    Problem,
    design,
    fit,
    in_floors,
    residuals,
    weighted,
    with_best_shape,
)
from exogauge.payload.missing.sensor_effects import low_pass
from exogauge.payload.missing.stretch import Stretch

Array = NDArray[np.float64]

STEP = 1e-4  # of differences by shapes, in shares of their ranges
CLOSELY = 0.01  # how far from where it stands a single shape is looked for, in shares of its range


def numbers(problem: Problem, found: Fitted, named: Sequence[Named], which: int) -> Array:
    """What is told of one of those that were named."""
    each = named[which]
    return each.effect.told(problem.frame, np.array(each.shape), found.x[_place(named, which)])


def numbers_with_std(problem: Problem, found: Fitted, named: Sequence[Named], which: int) -> tuple[Array, Array]:
    """The same, and their standard deviations; of what swings by the slow means that its shape is from."""
    if named[which].effect.swings:
        problem = problem.slow()
        found = fit(problem, named)
    effect, shape = named[which].effect, np.array(named[which].shape)
    own, before = _place(named, which), sum(len(each.shape) for each in named[:which])
    pick = np.r_[own, len(found.x) + before : len(found.x) + before + len(shape)]
    C = covariance(problem, found, named)[np.ix_(pick, pick)]
    at, n = np.concatenate([found.x[own], shape]), own.stop - own.start

    def told(values: Array) -> Array:
        return effect.told(problem.frame, values[n:], values[:n])

    steps = np.concatenate([1e-4 * np.maximum(np.abs(found.x[own]), 1e-6), STEP * _ranges(effect)])
    J = np.column_stack([(told(at + e) - told(at - e)) / (2 * h) for h, e in zip(steps, np.diag(steps), strict=True)])
    std = np.sqrt(np.maximum(np.diag(J @ C @ J.T), 0.0))
    if effect.jumps:  # nothing changes until the next sample is passed
        of = next(each for each in problem.stretches if each.name == effect.of_log)
        std[0] = float(np.median(np.diff(of.time)))
    return told(at), std


def covariance(problem: Problem, found: Fitted, named: Sequence[Named]) -> Array:
    """(18 + P + S,) squared of x and of all shapes, by residuals where they are more than their floors."""
    slopes = []
    for which, each in enumerate(named):
        for k, width in enumerate(_ranges(each.effect)):
            ends = []
            for side in (-1.0, 1.0):
                shape = list(each.shape)
                shape[k] += side * STEP * float(width)
                moved = [replace(one, shape=tuple(shape)) if n == which else one for n, one in enumerate(named)]
                ends.append(_asked(problem, found, moved))
            slopes.append((ends[1] - ends[0]) / (2 * STEP * width))
    S = np.column_stack(slopes) if slopes else np.zeros((len(found.residual), 0))
    across = found.root.T @ S
    of_shapes = np.linalg.pinv(S.T @ S - across.T @ across)  # what shapes say beside all coefficients
    lift = np.linalg.solve(found.triangle, across)
    C = np.block([[found.covariance + lift @ of_shapes @ lift.T, -lift @ of_shapes], [-of_shapes @ lift.T, of_shapes]])
    return np.asarray(max(found.rss / found.rows, 1.0) * C)


def slightly_late(
    problem: Problem, found: Fitted, named: Sequence[Named], effect: Effect
) -> tuple[float, float, Array] | None:
    """[s] by which the wrench is late and its std, where that is beyond chance, and (18, 18) the square of what it does
    to body, zero and turn: too little to be named, it may be more than their doubt. effect: the delay."""
    step = 1e-4  # [s]
    ends = [_asked(problem, found, [*named, Named(effect, (side * step,))]) for side in (-1.0, 1.0)]
    slope = (ends[1] - ends[0]) / (2.0 * step)
    across = found.root.T @ slope
    square = float(slope @ slope - across @ across)
    if square <= 0.0:
        return None
    late, std = float(slope @ found.residual) / square, float(np.sqrt(max(found.rss / found.rows, 1.0) / square))
    if abs(late) < problem.criteria.payload_dynamic.mu_stds * std:
        return None
    shift = late * np.linalg.solve(found.triangle, across)[:SIZE]
    return late, std, np.outer(shift, shift)


def of_filter(problem: Problem, named: Sequence[Named], late: float) -> tuple[float, float, Array]:
    """[ms²] variance of the response of a filter by which the wrench is `late` [ms], its std, and (18, 18) the square
    of what that leaves open of body, zero and turn. By slow means: errors of smoothed accelerations have second
    derivatives, too. Before any data it is between that of a pure delay and that of one pole."""
    more, believed = [*named, Named(low_pass(), ())], 0.5 * late * abs(late)
    slow, whole = (fit(each, more) for each in (problem.slow(), problem))
    variance = max(slow.rss / slow.rows, 1.0) * slow.covariance[-1, -1]
    weight = believed**2 / (believed**2 + variance)
    std = float(np.sqrt(weight * variance))
    slope = whole.covariance[:SIZE, -1] / whole.covariance[-1, -1]
    return float(weight * slow.x[-1] + (1.0 - weight) * believed), std, std**2 * np.outer(slope, slope)


def slightly_inclined(
    problem: Problem, found: Fitted, named: Sequence[Named]
) -> tuple[tuple[float, float] | None, Array]:
    """[rad] by which the base seems to lean and its std, where that is beyond chance, and (18, 18) what the lean that
    nobody knows does to body and zero: what it seems to be, and how well that is known. Where the base was taken to be
    level, and it is too little to be named."""
    free = replace(problem, inclined=True)
    other = fit(free, named)
    C = covariance(free, other, named)[:SIZE, :SIZE]
    across, turn = C[:, SIZE - 2 :], other.x[SIZE - 2 : SIZE]
    of_turn = np.linalg.inv(C[SIZE - 2 :, SIZE - 2 :])
    shift = other.x[:SIZE] - found.x[:SIZE]
    doubt = across @ of_turn @ across.T + np.outer(shift, shift)
    size = float(np.linalg.norm(turn))
    beyond = float(np.sqrt(turn @ of_turn @ turn))
    told = (size, size / beyond) if beyond > problem.criteria.payload_dynamic.mu_stds else None
    return told, doubt


def of_unexplained(problem: Problem) -> Array:
    """(18, 18) square of what nothing explains, were it in the numbers of body, zero and turn as it is in what is left:
    as large in each of them as what is left would be in one number, were it of as many. By slow means: what is fast,
    as knocks, averages out."""
    slow = problem.slow()
    slow = slow.of([replace(each, memory=1.0) for each in slow.stretches])
    found = fit(slow, [])
    share = max(found.rss - found.rows, 0.0) / SIZE
    return np.asarray(share * found.covariance)


def is_foretold(problem: Problem, found: Fitted, named: Sequence[Named], stretch: Stretch) -> NDArray[np.bool_]:
    """(6,) whether what was fitted says what a channel should read to better than its floor, were there nothing but
    noise: else what is left there tells nothing."""
    D = design(problem.frame, stretch, named)[stretch.use]
    variance = np.mean(np.einsum("tip,pq,tiq->ti", D, found.covariance, D, optimize=True), axis=0)
    return np.asarray(np.sqrt(variance) < problem.criteria.judging.above * stretch.floor)


def below_floor(problem: Problem, found: Fitted) -> bool:
    """Whether the fit took more off a channel than was there to be explained: errors of the kinematics, too."""
    sure = problem.criteria.judging.sure_above
    moving = [
        values for values, of in zip(in_floors(problem, found.residual), problem.stretches, strict=True) if not of.still
    ]
    return any(
        bool(np.any(np.mean(each**2, axis=0) < 1.0 - sure * np.sqrt(2.0 * correlation_time(each) / len(each))))
        for each in moving
    )


def by_slow_means(problem: Problem, named: Sequence[Named], own: Named) -> Named:
    """The same with the shape that means over many samples say: a smoother takes the fastest part of the accelerations
    away, which looks like less damping. named: those beside it."""
    slow = problem.slow()
    for _ in range(2):
        own = with_best_shape(slow, named, fit(slow, named), own.effect, [own.shape], CLOSELY)
        slow = slow.at(fit(slow, [*named, own]).x[:10])
    return own


def _asked(problem: Problem, found: Fitted, named: Sequence[Named]) -> Array:
    """(N,) what the model says of the rows, in their units."""
    rows = [
        weighted(each, (each.wrench - residuals(problem.frame, each, named, found.x))[:, :, None])
        for each in problem.stretches
    ]
    return np.append(np.concatenate(rows), np.zeros(SIZE))


def _place(named: Sequence[Named], which: int) -> slice:
    """Where an effect's coefficients stand in x."""
    sizes = [each.effect.coefficients for each in named]
    start = SIZE + sum(sizes[:which])
    return slice(start, start + sizes[which])


def _ranges(effect: Effect) -> Array:
    return np.array([high - low for low, high in effect.bounds])
