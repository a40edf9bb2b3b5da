"""Encoders whose zero is a little off: too little for a slip of a mapping, and enough to bear otherwise."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.examining import Comparing
from exogauge.identification.contacts import ContactPaths
from exogauge.identification.sites import with_zeros
from exogauge.plausibility.axis_fit import Likelihood
from exogauge.plausibility.described import asked_of
from exogauge.plausibility.expectation import Expected
from exogauge.plausibility.pooling import pooled
from exogauge.plausibility.relatives import related
from exogauge.plausibility.remedies import shifted
from exogauge.plausibility.summit import climb
from exogauge.robots.description import Robot

Array = NDArray[np.float64]
MOVING = ("dq", "ddq", "acc", "gyro", "gyro_dot")


@final
@dataclass(frozen=True)
class Zero:
    """angle: [rad] that has to be added to what was read of a joint.

    gain: log likelihood over no other zero. axis: the one that gains most; before, after: share of its effort that is
    left. rivals: joints, with their angles, that explain it as well.
    """

    joint: int
    angle: float
    gain: float
    axis: int
    before: float
    after: float
    rivals: tuple[tuple[int, float], ...] = ()


def find_zeros(robot: Robot, expected: Sequence[Expected]) -> Iterator[Zero]:
    """One after the other, the surest first, each found with those before it undone."""
    criteria, told = expected[0].seen.criteria, set[int]()
    some = np.unique(np.linspace(0, len(expected) - 1, round(criteria.as_good_as)).astype(int))
    expected = [expected[k] for k in some]
    while len(told) < criteria.most_slips:
        likely = [j for j in _likely(robot, expected) if j not in told][: criteria.most_doubted]
        found = sorted((_zero(robot, expected, j) for j in likely), key=lambda each: -each.gain)
        if not found or found[0].gain < criteria.zero or found[0].after > criteria.zero_falls * found[0].before:
            return
        best = found[0]
        close = [each for each in found[1:] if best.gain - each.gain < criteria.undecided]
        yield replace(best, rivals=tuple((each.joint, each.angle) for each in close))
        told |= {best.joint, *(each.joint for each in close)}
        expected = [Expected(robot, shifted(best.joint, best.angle)(each.seen)) for each in expected]


def moved_zeros(robot: Robot, expected: Sequence[Expected]) -> Iterator[tuple[str, Zero]]:
    """(log, zero) of encoders whose zero is another in one log than in all others: set anew where power came on, counts
    that were lost. What a description lacks would ask for the same zero in each; with its own a log is as described."""
    criteria = expected[0].seen.criteria if expected else Comparing()
    for one in expected if len(expected) > 1 else ():
        found = [_zero(robot, [one], j) for j in _likely(robot, [one])[: criteria.most_doubted]]
        best = max(found, key=lambda each: each.gain, default=None)
        if best is None or best.gain < criteria.zero or best.after > criteria.zero_falls * best.before:
            continue
        _, left = _with(robot, one, best)
        if left < criteria.misfit and all(
            _with(robot, other, best)[0] < -criteria.undecided for other in expected if other is not one
        ):
            yield one.seen.log, best


def _with(robot: Robot, expected: Expected, zero: Zero) -> tuple[float, float]:
    """What a log gains by a zero, in log likelihood; and the largest share of an effort that is left with it."""
    axes = [a for a in related(robot)[zero.joint] if expected.tells(a)]
    then = Expected(robot, shifted(zero.joint, zero.angle)(expected.seen), expected.moving)
    was, now = ([each.likelihood(a, near=True) for a in axes] for each in (expected, then))
    gain = sum(each.described for each in now) - sum(each.described for each in was)
    return gain, max((each.misfit for each in now), default=1.0)


def _likely(robot: Robot, expected: Sequence[Expected]) -> list[int]:
    """Joints whose zero gains enough to first order, the most first: the slopes of all at once cost no comparison."""
    axes = [a for a in range(len(robot.joints)) if any(each.tells(a) for each in expected)]
    slope, curve = np.zeros(len(robot.joints)), np.zeros(len(robot.joints))
    for each in expected:
        by_joint = _load_slopes(robot, each)
        for axis in (a for a in axes if each.tells(a)):
            b, H = each.fit(axis).slopes(each.effort[:, axis], by_joint[:, axis])
            slope, curve = slope + b, curve + H
    gain = 0.5 * slope**2 / np.maximum(curve, 1e-12)
    least = expected[0].seen.criteria.zero * expected[0].seen.criteria.screened
    own = set(with_zeros(robot))  # under a foot's wrench another zero looks like its sensor's error
    return [int(j) for j in np.argsort(-gain, kind="stable") if gain[j] > least and j in own]


def _load_slopes(robot: Robot, expected: Expected) -> Array:
    """(N, A, J) by how much each axis' load changes per radian of each joint's zero."""
    small = 0.01  # rad, of the difference quotient
    seen, J, axes = expected.seen, len(robot.joints), robot.rows.axes
    paths = ContactPaths(robot) if robot.contacts else None
    ways = []
    for step in (small, -small):
        q = np.concatenate([seen.q + step * own for own in np.eye(J)])
        tiled = replace(seen.motion, **{name: np.tile(getattr(seen, name), (J, 1)) for name in MOVING}, q=q)
        load = asked_of(robot, tiled, seen.recording)[:, axes]
        if paths is not None:
            load = load - paths.effect(q, np.tile(seen.wrenches, (J, 1, 1)))[:, axes]
        ways.append(load.reshape(J, len(seen.q), -1))
    return np.asarray(np.moveaxis((ways[0] - ways[1]) / (2.0 * small), 0, -1))


def _zero(robot: Robot, expected: Sequence[Expected], joint: int) -> Zero:
    """By full comparisons."""
    axes = [a for a in sorted(related(robot)[joint]) if any(each.tells(a) for each in expected)]

    @cache
    def by_axis(angle: float) -> list[Likelihood]:
        then = [Expected(robot, shifted(joint, angle)(each.seen), each.moving) for each in expected]
        return [pooled(then, a, near=True) for a in axes]

    def told(angle: float) -> float:
        return sum(each.described for each in by_axis(angle))

    at, angle = climb(told, 0.0, expected[0].seen.criteria.zero_step)
    gains = [now.described - was.described for was, now in zip(by_axis(0.0), by_axis(at), strict=True)]
    k = int(np.argmax(gains))
    return Zero(joint, angle, sum(gains), axes[k], by_axis(0.0)[k].misfit, by_axis(at)[k].misfit)
