"""Doctor's rules on the gyro: it turns as gravity's direction does in the accelerometer."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import permutations, product
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.examining import Examining
from exogauge.logs.derivatives import differentiate, differentiate_twice
from exogauge.logs.filtering import LowPass
from exogauge.logs.findings import ACC, GYRO, Expectation, Finding, vector
from exogauge.logs.model import Log
from exogauge.logs.noise import noise_of
from exogauge.logs.resampling import is_even
from exogauge.logs.units import STANDARD_GRAVITY

Array = NDArray[np.float64]


def gyro_against_tilt(log: Log, expected: Expectation) -> Iterator[Finding]:
    """The gyro must explain how gravity's direction n moves in the IMU: n x dn/dt = -(w - n (n.w)).

    A base that turns about a point beside the IMU accelerates as it turns, and the quicker the more: a lever of h looks
    like a gyro that is off by h w^2 / g. Where that may be so, sign and scale are asked of slower motion.
    """
    acc, gyro, criteria = vector(log, ACC), vector(log, GYRO), expected.criteria
    if acc is None or gyro is None or (widest := _tilting(log, acc, gyro, criteria.tilt_hz, criteria)) is None:
        return
    if not widest.omega.any():
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


def gyro_still(log: Log, expected: Expectation) -> Iterator[Finding]:
    """A gyro that tells its noise alone while gravity turns in the accelerometer.

    A base that shifts without turning, and accelerates, looks alike: so the way that it would have to go is asked.
    """
    acc, criteria = vector(log, ACC), expected.criteria
    gyro = log.stack(GYRO) if log.has(*GYRO) else np.full((1, 3), np.nan)
    if acc is None or not np.isfinite(gyro).all() or log.samples < criteria.noise_samples:
        return
    tilting = _tilting(log, acc, gyro, criteria.tilt_hz, criteria)
    if tilting is None:
        return
    noise = [each.std for each in noise_of(list(gyro.T), log.rate_hz, criteria.noise_above * log.rate_hz)]
    white = float(np.linalg.norm(noise)) * np.sqrt(2.0 * criteria.tilt_hz / log.rate_hz)  # of it, below tilt_hz
    turns, tells = _rms(tilting.seen), _rms(tilting.omega - tilting.omega.mean(axis=0))
    if tells > min(criteria.gyro_noise * white, criteria.gyro_unlike * turns):
        return
    if abs(tilting.likeness) > criteria.gyro_unlike:
        return
    tilts = _rms(tilting.up - tilting.up.mean(axis=0))
    way = STANDARD_GRAVITY * tilts**3 / turns**2  # of a sway at turns / tilts [rad/s] whose acceleration is g tilts
    detail = (
        f"tells no more than noise, {tells:.2g} rad/s, while gravity's direction in the accelerometer turns at "
        f"{turns:.2g} rad/s, by {np.degrees(tilts):.2g}° (rms)"
    )
    advice = "is it connected, and the column the right one? Record again"
    if way < criteria.level_m:
        advice = f"does the base shift by {100.0 * way:.2g} cm (rms) without turning? If not: {advice}"
    yield Finding("warning" if way < criteria.level_m else "error", "gyro", "gyro_still", detail, advice, value=tells)


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
        return lever / STANDARD_GRAVITY * float(np.linalg.norm(self.jerk))


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
    if np.sqrt(np.mean(seen**2)) < criteria.tilt_rate:
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
        clock = f"{gain:.3g} times too slow" if gain > 1.0 else f"{1.0 / gain:.3g} times too fast"
        advice = f"check its unit and scale, and the log's clock or `rate_hz`: one that is {clock} looks the same"
        yield Finding("warning", "gyro", "gyro_scale", detail, advice, value=gain)


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


def _rms(vectors: Array) -> float:
    """(T, 3) of their lengths."""
    return float(np.sqrt(np.mean(np.sum(vectors**2, axis=1))))
