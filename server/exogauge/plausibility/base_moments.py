"""What moments about the base tell of contact sensors: columns that were exchanged, as the load goes from one to the
other, a sensor's axes that were, another clock than that of the positions, and moments in another unit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations, permutations, product
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.contacts import ContactPaths
from exogauge.logs.units import UNITS
from exogauge.plausibility.base_fit import MOMENTS, BaseFit, spread_of
from exogauge.plausibility.described import asked_of
from exogauge.plausibility.snapshot import Snapshot
from exogauge.plausibility.summit import summit
from exogauge.robots.description import Robot

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Exchanged:
    """Two contact sensors, by number. before, after: of how much the moments that they give change, the share that
    bodies as described do not ask for; as it was read, and the other way round."""

    pair: tuple[int, int]
    before: float
    after: float

    def undo(self, seen: Snapshot) -> Snapshot:
        order = list(range(seen.wrenches.shape[1]))
        for one, other in (self.pair, self.pair[::-1]):
            order[one] = other
        return replace(seen, wrenches=seen.wrenches[:, order], late_wrenches=seen.late_wrenches[:, :, order])


@final
@dataclass(frozen=True)
class MomentUnit:
    """Of all contact sensors. factor: by which their moments have to be multiplied. before, after: as in `Exchanged`,
    each of how much the moments change that are given with that factor."""

    factor: float
    before: float
    after: float

    def undo(self, seen: Snapshot) -> Snapshot:
        size = np.repeat([1.0, self.factor], 3)
        return replace(seen, wrenches=seen.wrenches * size, late_wrenches=seen.late_wrenches * size)


@final
@dataclass(frozen=True)
class OtherAxes:
    """sensors: by number. read: for each of x, y, z of the frame, which column holds it, and with which sign.
    before, after: as in `Exchanged`."""

    sensors: tuple[int, ...]
    read: tuple[tuple[int, float], ...]
    before: float
    after: float

    def undo(self, seen: Snapshot) -> Snapshot:
        order, signs = (np.array(each) for each in zip(*self.read, strict=True))
        both, wrenches, late = np.concatenate([order, order + 3]), seen.wrenches.copy(), seen.late_wrenches.copy()
        for sensor in self.sensors:
            wrenches[:, sensor] = wrenches[:, sensor][:, both] * np.tile(signs, 2)
            late[:, :, sensor] = late[:, :, sensor][:, :, both] * np.tile(signs, 2)
        return replace(seen, wrenches=wrenches, late_wrenches=late)

    @property
    def words(self) -> str:
        return ", ".join(
            f"{axis} := {'-' if sign < 0.0 else ''}{'xyz'[k]}" for axis, (k, sign) in zip("xyz", self.read, strict=True)
        )


@final
@dataclass(frozen=True)
class Late:
    """Of one log. seconds: > 0 late. before, after: as in `Exchanged`, as it was read, and taken from that much later.
    shift: the place of the nearest among the snapshot's lags. of_imu: the base's motion is, else the contact sensors.
    by_legs: before and after are of how the base turns by legs that stand (`late_gyro.py`).
    """

    seconds: float
    before: float
    after: float
    shift: int
    of_imu: bool = False
    by_legs: bool = False

    def undo(self, seen: Snapshot) -> Snapshot:
        if self.of_imu:
            acc, gyro, gyro_dot = seen.late_imu[self.shift]
            return replace(seen, acc=acc, gyro=gyro, gyro_dot=gyro_dot)
        return replace(seen, wrenches=seen.late_wrenches[self.shift])


def exchanged_contacts(robot: Robot, seen: Sequence[Snapshot]) -> Exchanged | None:
    """In all of the logs. None where the load does not go from one to another, so that no moment tells them apart.

    What is left is held against what an exchange changes: motions in which both feet bear alike say nothing of it.
    """
    if not robot.tree.floating or len(robot.contacts) < 2 or not seen:
        return None
    criteria = seen[0].criteria
    asked, given = [_asked(robot, each) for each in seen], [_given(robot, each) for each in seen]
    swings = spread_of(given)
    before = _difference(asked, given)
    if swings <= 0.0:
        return None
    found = []
    for pair in combinations(range(len(robot.contacts)), 2):
        tried = Exchanged(pair, before / swings, 0.0)
        other = [_given(robot, tried.undo(each)) for each in seen]
        if before >= criteria.sides_before * _difference(given, other):
            found.append(replace(tried, after=_difference(asked, other) / swings))
    best = min(found, key=lambda each: each.after, default=None)
    return best if best and best.after < criteria.sides_falls * best.before else None


def contact_axes(robot: Robot, seen: Sequence[Snapshot]) -> OtherAxes | None:
    """In all of the logs, of one sensor, or of all alike: exchanged and reversed axes, forces and moments together.
    What is left is held against what a reading changes. None where two sensors that are exchanged leave no more.
    """
    if not robot.tree.floating or not robot.contacts or not seen:
        return None
    criteria, asked = seen[0].criteria, [_asked(robot, each) for each in seen]
    given = [_given(robot, each) for each in seen]

    def left(tried: OtherAxes) -> tuple[float, float]:
        """What no body asks for so, and how much of the moments this reading changes."""
        so = [_given(robot, tried.undo(each)) for each in seen]
        return _difference(asked, so) / swings, _difference(given, so) / swings

    swings = spread_of(asked)
    before = _difference(asked, given) / swings if swings > 0.0 else 0.0
    if before <= 0.0:
        return None
    sensors: list[tuple[int, ...]] = [(each,) for each in range(len(robot.contacts))]
    sensors += [tuple(range(len(robot.contacts)))] if len(robot.contacts) > 1 else []
    reads = [
        tuple(zip(order, signs, strict=True))
        for order in permutations(range(3))
        for signs in product((1.0, -1.0), repeat=3)
    ]
    found = list[OtherAxes]()
    for some, read in product(sensors, reads):
        after, changed = left(tried := OtherAxes(some, read, before, 0.0))
        if before >= criteria.sides_before * changed:
            found.append(replace(tried, after=after))
    best = min(found, key=lambda each: each.after)
    if len(best.sensors) == len(robot.contacts) and best.read == tuple((axis, -1.0) for axis in range(3)):
        return None  # the weight tells whether they are reversed: if not, the accelerometer is
    sides = exchanged_contacts(robot, seen)
    most = min(
        criteria.sides_before, criteria.sides_falls * before, sides.after * before / sides.before if sides else np.inf
    )
    return best if best.after < most else None


def moment_unit(robot: Robot, seen: Sequence[Snapshot]) -> MomentUnit | None:
    """In all of the logs: a unit for another, with which most of what was left is asked for, and no less than of feet
    that are right. None where moments are as described, or no unit makes them so."""
    if not robot.tree.floating or not robot.contacts or not seen:
        return None
    criteria, asked = seen[0].criteria, [_asked(robot, each) for each in seen]

    def tried(factor: float) -> tuple[float, float]:
        scaled = MomentUnit(factor, 0.0, 0.0)
        given = [_given(robot, scaled.undo(each)) for each in seen]
        return _difference(asked, given), spread_of(given)

    left, swings = tried(1.0)
    if swings <= 0.0 or left < criteria.sides_before * swings:
        return None
    units = {each.factor for each in UNITS.values() if each.dimension == "torque" and each.factor != 1.0}
    found = {factor: tried(factor) for factor in sorted(units | {1.0 / each for each in units})}
    best = min(found, key=lambda factor: found[factor][0])
    least, then = found[best]
    if least >= criteria.sides_falls * left or least >= criteria.sides_before * then:
        return None
    return MomentUnit(best, left / swings, least / then)


def late_imu_or_contacts(robot: Robot, seen: Snapshot) -> Late | None:
    """What is late by itself: all contact sensors alike, or the IMU. None where no shift halves what is left by bodies
    that are off by as much as stated, or one by hardly any time does.

    Joints tell which: a base's own sway is given by both, and would as well be early in the one as late in the other.
    """
    if not robot.tree.floating or not robot.contacts:
        return None
    criteria, fit = seen.criteria, BaseFit(robot, [seen])
    if fit.swings <= 0.0:
        return None
    found = list[Late]()
    for of_imu in (False, True):
        tried = [Late(0.0, 0.0, 0.0, shift, of_imu).undo(seen) for shift in range(len(seen.lags))]
        left = [fit.left([each]) for each in tried]
        if of_imu and seen.lags[best := int(np.argmin(left))] != 0.0:  # what bodies may ask for goes with it
            then = BaseFit(robot, [tried[best]])
            left = [then.left([each]) for each in tried]
        if late := _late(seen, np.array(left), of_imu):
            found.append(late)
    late = min(found, key=lambda each: each.after, default=None)
    least = criteria.imu_delay_least_s if late and late.of_imu else criteria.delay_least_s
    return late if late and abs(late.seconds) >= max(least, criteria.delay_samples / seen.rate_hz) else None


def _late(seen: Snapshot, left: Array, of_imu: bool) -> Late | None:
    """left: (LAGS,)"""
    best, at_once = int(np.argmin(left)), int(np.argmin(np.abs(seen.lags)))
    if best in (0, len(left) - 1) or left[best] > seen.criteria.delay_far_falls * left[at_once]:
        return None
    seconds = summit(seen.lags[best - 1 : best + 2], -(left[best - 1 : best + 2] ** 2))
    return Late(seconds, float(left[at_once]), float(left[best]), best, of_imu)


def _asked(robot: Robot, seen: Snapshot) -> Array:
    """(N, 3) by the bodies as described."""
    return asked_of(robot, seen.motion, seen.recording)[:, MOMENTS]


def _given(robot: Robot, seen: Snapshot) -> Array:
    """(N, 3) by the sensors."""
    return ContactPaths(robot).effect(seen.q, seen.wrenches)[:, MOMENTS]


def _difference(some: Sequence[Array], others: Sequence[Array]) -> float:
    return spread_of([a - b for a, b in zip(some, others, strict=True)])
