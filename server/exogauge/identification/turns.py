"""When axes move, which way, and when they rest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.identifying import Resting
from exogauge.logs.bandwidth import suggest_cutoff
from exogauge.logs.derivatives import derivative_noise_gain, differentiate
from exogauge.logs.filtering import LowPass, StoredPass
from exogauge.logs.model import Log
from exogauge.logs.noise import noise_of
from exogauge.logs.undoing import StoredPositions
from exogauge.robots.description import Robot
from exogauge.side_by_side import each as side_by_side

Array = NDArray[np.float64]

NONE_CREEPS: Mapping[str, float] = MappingProxyType({})
WIDEST = 0.4  # of the sampling rate: the highest cut-off a log can be filtered at


@final
@dataclass(frozen=True)
class RestDetection:
    """When an axis counts as at rest: |velocity| below threshold (A,) [rad/s], at the bandwidth cutoff_hz.

    creeping: (A,) [rad/s] below it an axis moves, but not steadily: its friction is not what it is at speed.
    criteria: by which that was found, and steady motion is.
    """

    cutoff_hz: float
    threshold: Array
    creeping: Array
    criteria: Resting = field(default_factory=Resting)


def rest_detection(
    robot: Robot,
    logs: Sequence[Log],
    cutoff_hz: float,
    creeping: Mapping[str, float] = NONE_CREEPS,
    criteria: Resting | None = None,
) -> RestDetection:
    """At all the bandwidth that the encoders can bear, at least cutoff_hz; thresholds from the noise of the velocity.

    A joint sticks for moments that a velocity smoothed for the equations would glide over.
    creeping: as `Settings.creeping`.
    """
    criteria = criteria or Resting()
    joints = [f"q.{joint.name}" for joint in robot.joints]
    finest = max(cutoff_hz, *side_by_side(lambda log: suggest_cutoff(log.stack(joints), log.rate_hz), logs))

    def of_log(log: Log) -> tuple[Array, Array]:
        q, low_pass = log.stack(joints), LowPass(finest, log.rate_hz)
        std = np.array([each.std for each in noise_of(list(q.T), log.rate_hz, 0.25 * log.rate_hz)])
        noise = derivative_noise_gain(low_pass, 1) * np.maximum(std, robot.noise.get("q", 0.0))
        return noise, np.abs(differentiate(low_pass.apply(q), log.rate_hz)).max(axis=0)

    noise, top = (np.max(each, axis=0) for each in zip(*side_by_side(of_log, logs), strict=True))
    mixing = np.abs(robot.axes_from_joints)
    axis_noise = np.sqrt(mixing**2 @ noise**2)
    seen = np.maximum(criteria.sigmas * axis_noise, criteria.share * (mixing @ top))
    slow = np.array([creeping.get(joint.name, 0.0) for joint in robot.joints])
    return RestDetection(finest, np.maximum(seen, criteria.slowest), slow, criteria)


@final
@dataclass(frozen=True)
class Turns:
    """direction: (T, A) -1, 0, 1, unfiltered, as late as slow motion came out of the low-pass that the log had passed.

    stored_direction, stored_rest: (T, A) the direction, and 1 - |direction|, as they came out of that low-pass.
    """

    direction: Array
    stored_direction: Array
    stored_rest: Array


@final
class TurnsOf:
    """Of one log, behind any low-pass that it may have passed before it was stored."""

    def __init__(self, robot: Robot, log: Log, at_rest: RestDetection) -> None:
        self._rate_hz, self._at_rest, self._robot = log.rate_hz, at_rest, robot
        self._finest = LowPass(min(at_rest.cutoff_hz, WIDEST * log.rate_hz), log.rate_hz)
        self._positions = StoredPositions(log, [f"q.{joint.name}" for joint in robot.joints], self._finest)

    def behind(self, stored: StoredPass | None) -> Turns:
        """A low-passed log shows no rests shorter than its band: what is slow for less has turned round."""
        then, likely = self._seen_behind(stored)
        if stored is None:
            return Turns(then, then, 1.0 - np.abs(then))
        passed, resting = (stored.let_through(x, self._rate_hz) for x in (likely, 1.0 - np.abs(then)))
        late = min(round(stored.delay_s(self._rate_hz) * self._rate_hz), len(then))
        return Turns(np.concatenate([np.repeat(then[:1], late, axis=0), then[: len(then) - late]]), passed, resting)

    def stored_direction(self, stored: StoredPass) -> Array:
        """That of `behind` alone, for those who try many."""
        return stored.let_through(self._seen_behind(stored)[1], self._rate_hz)

    def _seen_behind(self, stored: StoredPass | None) -> tuple[Array, Array]:
        """(T, A) each: the direction, when it was, and the same as it is likely at every sample."""
        rate_hz, band_hz, q = self._rate_hz, self._finest.cutoff_hz, self._positions.before(stored)
        if stored is not None:
            band_hz = min(band_hz, stored.half_hz(rate_hz))
            q = LowPass(min(self._finest.cutoff_hz, self._at_rest.criteria.smooth * band_hz), rate_hz).apply(q)
        velocity = self._robot.on_axes(differentiate(q, rate_hz))
        then = directions(velocity, self._at_rest.threshold, round(rate_hz / band_hz))
        return then, then if stored is None else then * _sureness(velocity, self._at_rest.criteria.barely)


def _sureness(velocity: Array, barely: float) -> Array:
    """(T, A) 0 where an axis turns round at a sample's very instant, which may lie before or after it: the mean of both
    signs is nothing; 1 from `barely` samples on."""
    before, after = velocity[:-1], velocity[1:]
    turning = before * after < 0.0
    share = np.where(turning, before / np.where(turning, before - after, 1.0), 0.5)
    sure = np.ones(velocity.shape)
    sure[:-1] = np.minimum(sure[:-1], share / barely)
    sure[1:] = np.minimum(sure[1:], (1.0 - share) / barely)
    return sure


def directions(velocity: Array, threshold: Array, shortest: int) -> Array:
    """(T, A) sgn_ε: 0 where an axis stays below its threshold for at least `shortest` samples, else the sign.

    A velocity that merely passes through zero is a reversal, not a rest: static friction has no time to act that a
    low-passed log could show.
    """
    direction = np.sign(velocity)
    slow = np.abs(velocity) < threshold
    for axis in range(velocity.shape[1]):
        edges = np.flatnonzero(np.diff(np.concatenate([[False], slow[:, axis], [False]]).astype(np.int8)))
        for start, stop in edges.reshape(-1, 2):
            if stop - start >= shortest:
                direction[start:stop, axis] = 0.0
    return direction


def way_since_turn(q: Array, dq: Array) -> Array:
    """(T, J) of positions and velocities, from the first sample on."""
    turns = np.diff(dq > 0.0, axis=0, prepend=dq[:1] > 0.0)
    at = np.maximum.accumulate(np.where(turns, np.arange(len(q))[:, None], 0), axis=0)
    return np.abs(q - np.take_along_axis(q, at, axis=0))


def way_of_axes(robot: Robot, way: Array) -> Array:
    """(T, A) of (T, J): that of the joint that turned last, among those that an axis moves."""
    return np.stack([way[:, moved].min(axis=1) for moved in robot.axes_from_joints != 0.0], axis=1)
