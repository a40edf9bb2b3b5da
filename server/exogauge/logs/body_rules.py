"""Doctor's rules on the whole body: the IMU against gravity, the feet against the weight."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import permutations, product
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.constants import g

from exogauge.criteria.examining import Examining
from exogauge.logs.derivatives import differentiate, differentiate_twice
from exogauge.logs.filtering import LowPass
from exogauge.logs.findings import Expectation, Finding
from exogauge.logs.model import Log
from exogauge.logs.resampling import is_even
from exogauge.logs.units import UNITS

Array = NDArray[np.float64]

ACC, GYRO = ("acc.x", "acc.y", "acc.z"), ("gyro.x", "gyro.y", "gyro.z")
WRENCH = ("fx", "fy", "fz", "mx", "my", "mz")
ACC_UNITS = {"g": 1.0, "cm/s²": 100.0 * g, "mm/s²": 1000.0 * g, "milli-g": 1000.0}


def gravity_at_rest(log: Log, expected: Expectation) -> Iterator[Finding]:
    """|acc| while the body turns least must be 9.81 m/s²."""
    acc = _vector(log, ACC)
    if acc is None:
        return
    size = float(np.median(np.linalg.norm(acc[_at_rest(log, acc, expected.criteria.resting)], axis=1)))
    if abs(size / g - 1.0) <= expected.criteria.gravity:
        return
    units = [unit for unit, at_rest in ACC_UNITS.items() if abs(size / at_rest - 1.0) <= expected.criteria.gravity]
    detail = f"|acc| at rest is {size:.4g}, not {g:.2f} m/s²"
    if units:
        advice = f"declare the unit as {units[0]} in the mapping"
        yield Finding("error", "acc", "acceleration_unit", detail, advice, value=size)
    elif size < 0.1 * g:
        advice = "gravity was taken out of it; the proper acceleration (+9.81 up at rest) is needed"
        yield Finding("error", "acc", "gravity_missing", detail, advice, value=size)
    else:
        advice = "check its unit and calibration, and that the body really rests at times"
        yield Finding("warning", "acc", "acceleration_scale", detail, advice, value=size)


def gyro_against_tilt(log: Log, expected: Expectation) -> Iterator[Finding]:
    """The gyro must explain how gravity's direction n moves in the IMU: n x dn/dt = -(w - n (n.w)).

    A base that turns about a point beside the IMU accelerates as it turns, and the quicker the more: a lever of h looks
    like a gyro that is off by h w^2 / g. Where that may be so, sign and scale are asked of slower motion.
    """
    acc, gyro, criteria = _vector(log, ACC), _vector(log, GYRO), expected.criteria
    if acc is None or gyro is None or (widest := _tilting(log, acc, gyro, criteria.tilt_hz, criteria)) is None:
        return
    likeness, gain = widest.likeness, widest.gain
    if likeness > 0.8 and 40.0 < gain < 80.0:
        detail = f"turns {gain:.3g} times faster than gravity's direction in the accelerometer"
        yield Finding(
            "error", "gyro", "gyro_in_degrees", detail, "declare the unit as deg/s in the mapping", value=gain
        )
    elif abs(likeness) > 0.8:
        slower = (_tilting(log, acc, gyro, criteria.tilt_hz / factor, criteria) for factor in (2.0, 4.0))
        for each in (widest, *slower):
            if each is None or each.missed > each.by_lever(*criteria.levers_m):
                yield from _sign_or_scale(each)
                return
    elif (
        likeness < criteria.gyro_unlike
        and (axes := _gyro_axes(widest.up, widest.seen, widest.gyro, criteria)) is not None
    ):
        detail = f"does not turn as gravity's direction in the accelerometer does (likeness {likeness:.2f})"
        advice = f"in a mapping, take for gyro {axes}, or exchange those of acc"
        yield Finding("error", "gyro", "gyro_frame", detail, advice, value=likeness)


@final
@dataclass(frozen=True)
class _Tilting:
    """Below a frequency. up: (T, 3) direction of the proper acceleration. gyro: (T, 3) [rad/s]. seen: (T, 3) [rad/s]
    across up, by which it turns. omega: (T, 3) what of the gyro does. jerk: (T, 3) [rad/s³] its second derivative."""

    up: Array
    gyro: Array
    seen: Array
    omega: Array
    jerk: Array

    @property
    def likeness(self) -> float:
        return _likeness(self.seen, self.omega)

    @property
    def gain(self) -> float:
        return float(np.linalg.norm(self.omega) / np.linalg.norm(self.seen)) * float(np.sign(self.likeness))

    @property
    def missed(self) -> float:
        return float(np.linalg.norm(self.seen - self.omega))

    def by_lever(self, below_m: float, above_m: float) -> float:
        """Of that, what the base's acceleration may be, as it turns about a point so far below or above the IMU: about
        one below more seems to turn than turns, about one above less, or the other way."""
        lever = below_m if 0.0 < self.gain < 1.0 else above_m
        return lever / g * float(np.linalg.norm(self.jerk))


def _tilting(log: Log, acc: Array, gyro: Array, below_hz: float, criteria: Examining) -> _Tilting | None:
    """None where nothing can be said: too short, too slow, or no gravity in it."""
    if not is_even(log.time) or log.rate_hz < 10.0 * below_hz:
        return None
    low_pass = LowPass(below_hz, log.rate_hz)
    if log.samples < 4 * low_pass.settle_samples:
        return None
    slow = low_pass.apply(acc)
    size = np.linalg.norm(slow, axis=1)
    if np.std(size) > criteria.steady * np.mean(size):
        return None  # no gravity in it, or too much else: another rule's business
    up, whole = slow / size[:, None], low_pass.apply(gyro)
    seen, jerk = -np.cross(up, differentiate(up, log.rate_hz)), differentiate_twice(whole, log.rate_hz)
    inner = slice(low_pass.settle_samples, -low_pass.settle_samples)
    up, whole, seen, jerk = up[inner], whole[inner], seen[inner], jerk[inner]
    omega = _across(up, whole)
    if np.sqrt(np.mean(seen**2)) < criteria.tilt_rate or not omega.any():
        return None
    return _Tilting(up, whole, seen, omega, _across(up, jerk))


def _sign_or_scale(tilting: _Tilting | None) -> Iterator[Finding]:
    if tilting is None:
        return
    likeness, gain = tilting.likeness, tilting.gain
    if likeness < -0.8:
        detail = "turns against the way gravity's direction moves in the accelerometer"
        advice = "one of the two has its sign or its frame reversed"
        yield Finding("error", "gyro", "gyro_sign", detail, advice, value=gain)
    elif likeness > 0.8 and not 0.7 < gain < 1.4:
        detail = f"turns {gain:.3g} times as fast as gravity's direction in the accelerometer"
        yield Finding("warning", "gyro", "gyro_scale", detail, "check its unit and scale", value=gain)


def _gyro_axes(up: Array, seen: Array, gyro: Array, criteria: Examining) -> str | None:
    """The exchange of its axes with which the gyro explains what is seen, where one does and no other nearly as well.

    All 48 are tried: of three axes one may have its sign reversed. Of a body that stays upright the vertical axis says
    nothing; then of two that differ in one sign the right-handed one is taken.
    """
    found = [
        (_likeness(seen, _across(up, gyro[:, order] * signs)), order, signs)
        for order in permutations(range(3))
        for signs in product((1.0, -1.0), repeat=3)
    ]
    best = max(likeness for likeness, *_ in found)
    near, doubt = [each for each in found if criteria.more_alike * (1.0 - each[0]) <= 1.0 - best], ""
    if len(near) == 2:
        doubt = " (one sign, which these logs cannot tell, by the right hand)"
        near = [each for each in near if np.linalg.det(np.eye(3)[list(each[1])]) * np.prod(each[2]) > 0.0]
    if best < criteria.gyro_alike or len(near) != 1:
        return None
    _, order, signs = near[0]
    source = [f"{'-' if sign < 0.0 else ''}{'xyz'[k]}" for k, sign in zip(order, signs, strict=True)]
    return ", ".join(f"{axis} := {each}" for axis, each in zip("xyz", source, strict=True)) + doubt


def _across(up: Array, omega: Array) -> Array:
    """What of an angular velocity moves gravity's direction."""
    return np.asarray(omega - up * np.sum(up * omega, axis=1)[:, None])


def _likeness(seen: Array, omega: Array) -> float:
    return float(np.sum(seen * omega) / (np.linalg.norm(seen) * np.linalg.norm(omega) + 1e-12))


def feet_carry_the_weight(log: Log, expected: Expectation) -> Iterator[Finding]:
    """Over a log that starts and ends standing, the mean of the total Fz is m g."""
    sensors = tuple(expected.contacts)
    names = [f"ft.{name}.fz" for name in sensors]
    if expected.weight_n is None or not sensors or not log.has(*names):
        return
    upward = log.stack(names)
    upward = upward[np.isfinite(upward).all(axis=1)]
    if not upward.size:
        return
    signs = np.array([expected.contacts[name] for name in sensors])
    lifts = signs * upward.mean(axis=0) / expected.weight_n
    ratio = float(lifts.sum())
    if abs(ratio - 1.0) <= expected.criteria.weight:
        return
    detail = f"the feet carry {ratio:.3g} of the weight of {expected.weight_n:.4g} N"
    units = {name: unit.factor for name, unit in UNITS.items() if unit.dimension == "force" and unit.factor != 1.0}
    unit = next((name for name, size in units.items() if abs(ratio * size - 1.0) <= expected.criteria.weight), None)
    if abs(ratio + 1.0) <= expected.criteria.weight_sign:
        advice = "the wrenches are those of the robot on the world: change `sees` in robot.yaml, or the sign"
        yield Finding("error", "ft.*", "wrench_sign", detail, advice, value=ratio)
    elif abs(float(np.abs(lifts).sum()) - 1.0) <= expected.criteria.weight:
        turned = ", ".join(name for name, lift in zip(sensors, lifts, strict=True) if lift < 0.0)
        yield Finding("error", "ft.*", "wrench_sign", detail, f"only {turned} has its sign reversed", value=ratio)
    elif unit:
        yield Finding("error", "ft.*", "force_unit", detail, f"declare the unit as {unit} in the mapping", value=ratio)
    else:
        yield from _weight_elsewhere(log, expected, sensors, signs, detail, ratio)


def _weight_elsewhere(
    log: Log, expected: Expectation, sensors: Sequence[str], signs: Array, detail: str, ratio: float
) -> Iterator[Finding]:
    """The weight found in another column: couple before force, or another axis up."""
    assert expected.weight_n is not None
    for axis in WRENCH:
        names = [f"ft.{name}.{axis}" for name in sensors]
        if axis == "fz" or not log.has(*names) or not np.isfinite(log.stack(names)).all():
            continue
        share = float(signs @ log.stack(names).mean(axis=0)) / expected.weight_n
        if abs(abs(share) - 1.0) > expected.criteria.weight_sign:
            continue
        if axis.startswith("m"):
            advice = f"the weight is in {axis}: the columns hold the couple first, declare that order in the mapping"
            yield Finding("error", "ft.*", "couple_first", detail, advice, value=ratio)
        else:
            advice = f"the weight is in {axis}: right if that axis of the sensors is upright"
            yield Finding("warning", "ft.*", "weight_on_another_axis", detail, advice, value=ratio)
        return
    advice = "does the robot lean on something else, or is the force scale, the zero or the mass of the URDF wrong?"
    yield Finding("warning", "ft.*", "weight_differs", detail, advice, value=ratio)


def _vector(log: Log, names: tuple[str, str, str]) -> Array | None:
    """(T, 3), or None where a column or a value is missing."""
    if not log.has(*names):
        return None
    vector = log.stack(names)
    return vector if np.isfinite(vector).all() and vector.any() else None


def _at_rest(log: Log, acc: Array, resting: float) -> NDArray[np.bool_]:
    """(T,) the samples with the least rotation; without a gyro, those with the least change of acceleration."""
    gyro = _vector(log, GYRO)
    activity = np.linalg.norm(np.gradient(acc, axis=0) if gyro is None else gyro - np.median(gyro, axis=0), axis=1)
    return np.asarray(activity <= np.quantile(activity, resting))
