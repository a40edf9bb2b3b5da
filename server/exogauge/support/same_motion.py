"""Whether two logs hold the same motion, and how much later it comes in one of them.

Approach A subtracts one run from another, so a shift in time becomes a torque: 5 ms were worth 0.03 N·m rms in trials,
20 ms 0.25 N·m with peaks at starts and stops.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
import scipy
from numpy.typing import NDArray

from exogauge.criteria.supporting import MOTIONS
from exogauge.logs.derivatives import differentiate
from exogauge.logs.filtering import LowPass
from exogauge.logs.model import Log
from exogauge.support.result import JointEquality, Verdict
from exogauge.support.settings import SupportSettings

Array = NDArray[np.float64]

RESOLVED_S = 1e-6  # of a lag; logs that end together do so within it


@final
@dataclass(frozen=True)
class Match:
    """lag_s: time in the other log minus time in this one, each from its own first sample, for the same posture.

    equality: per joint asked for. first, last: this log's samples [first, last) that the other one covers.
    """

    lag_s: float
    equality: tuple[JointEquality, ...]
    first: int
    last: int

    @property
    def worst(self) -> Verdict:
        order: tuple[Verdict, ...] = ("equal", "doubtful", "different")
        return max((each.verdict for each in self.equality), key=order.index, default="equal")


@final
class Posture:
    """Angles and velocities of a log's joints as functions of the time since its first sample."""

    def __init__(self, log: Log, joints: Sequence[str]) -> None:
        low_pass = LowPass(min(MOTIONS.smooth_hz, 0.2 * log.rate_hz), log.rate_hz)
        self.rate, self.joints = log.rate_hz, tuple(joints)
        self.time = log.time - log.time[0]
        self.q = low_pass.apply(log.stack([f"q.{joint}" for joint in joints]))
        self.dq = differentiate(self.q, log.rate_hz)
        self._at = scipy.interpolate.make_interp_spline(self.time, np.hstack([self.q, self.dq]), k=3)

    def at(self, time: Array) -> tuple[Array, Array]:
        values = np.asarray(self._at(time))
        return values[:, : len(self.joints)], values[:, len(self.joints) :]


def match(this: Posture, other: Posture, settings: SupportSettings) -> Match:
    """Align two logs by all their joints' velocities and say how equal the motions are."""
    lag = _refined(this, other, _coarse_lag(this, other))
    first, last = _covered(this, other, lag)
    q, dq = other.at(this.time[first:last] + lag)
    missed = _missed(this, other, first, last, dq)
    shown = this.dq[first:last]
    own = np.sqrt(np.maximum(np.mean(shown**2, axis=0), np.mean(dq**2, axis=0)) + missed)
    q_rms = np.sqrt(np.mean((this.q[first:last] - q) ** 2, axis=0))
    dq_rms = np.sqrt(np.mean((shown - dq) ** 2, axis=0) + missed)
    share = np.where(own > MOTIONS.moving, dq_rms / np.maximum(own, MOTIONS.moving), 0.0)
    carried = own >= MOTIONS.minor * np.max(own, initial=0.0)
    equality = [
        JointEquality(
            joint,
            float(q_rms[j]),
            float(dq_rms[j]),
            float(share[j]),
            _verdict(share[j], q_rms[j], bool(carried[j]), settings),
        )
        for j, joint in enumerate(this.joints)
    ]
    return Match(lag, tuple(equality), first, last)


def _missed(this: Posture, other: Posture, first: int, last: int, dq: Array) -> Array:
    """(J,) mean square velocity that both logs hold outside what they share, where that is most of the motion.

    Per sample that they share; dq: the other's velocities there. Stand compared with stand would look equal.
    """
    shared = [np.sum(this.dq[first:last] ** 2, axis=0), np.sum(dq**2, axis=0)]
    whole = [np.sum(this.dq**2, axis=0), np.sum(other.dq**2, axis=0) * this.rate / other.rate]
    common = np.max([s / np.maximum(w, 1e-300) for s, w in zip(shared, whole, strict=True)], axis=0)
    outside = np.min([w - s for s, w in zip(shared, whole, strict=True)], axis=0)
    return np.asarray(np.where(common < MOTIONS.common, np.maximum(outside, 0.0), 0.0) / max(last - first, 1))


def _verdict(share: float, q_rms: float, carried: bool, settings: SupportSettings) -> Verdict:
    """carried: the joint has part in the motion: what another merely gives way to it by makes no other motion of it."""
    if share > settings.different and carried:
        return "different"
    return "doubtful" if share > settings.doubtful or q_rms > MOTIONS.stands_apart else "equal"


def _coarse_lag(this: Posture, other: Posture) -> float:
    """The lag, on this log's clock, at which least motion is left: the square difference of the velocities where both
    logs are, and what both hold elsewhere, or stand would be laid upon stand.
    """
    valley_s = 0.2  # a shift is the best within that [s]
    steps = int(np.floor(other.time[-1] * this.rate)) + 1
    a, b = this.dq, other.at(np.arange(steps) / this.rate)[1]
    cross = sum(scipy.signal.fftconvolve(b[:, j], a[::-1, j]) for j in range(a.shape[1]))
    lags = np.arange(-len(a) + 1, len(b))
    start, stop = np.maximum(0, -lags), np.minimum(len(a), len(b) - lags)
    common = stop - start
    fair = common >= MOTIONS.overlap * min(len(a), len(b))
    lags, start, stop = lags[fair], start[fair], stop[fair]
    a_sum, b_sum = (np.concatenate([[0.0], np.cumsum(np.sum(x**2, axis=1))]) for x in (a, b))
    of_a, of_b = a_sum[stop] - a_sum[start], b_sum[stop + lags] - b_sum[start + lags]
    elsewhere = np.minimum(a_sum[-1] - of_a, b_sum[-1] - of_b)
    apart = of_a + of_b - 2.0 * np.asarray(cross)[fair] + elsewhere
    valley = apart <= scipy.ndimage.minimum_filter1d(apart, 2 * round(valley_s * this.rate) + 1, mode="nearest")
    good = valley & (apart <= apart.min() + MOTIONS.alike * min(a_sum[-1], b_sum[-1]))  # of equals, the smallest shift
    return float(lags[good][np.argmin(np.abs(lags[good]))]) / this.rate


def _refined(this: Posture, other: Posture, lag: float) -> float:
    """Gauss-Newton on the lag: between samples too."""
    refinements = 20
    for _ in range(refinements):
        first, last = _covered(this, other, lag)
        time = this.time[first:last] + lag
        dq = other.at(time)[1]
        slope = np.gradient(dq, 1.0 / this.rate, axis=0)
        step = float(np.sum(slope * (this.dq[first:last] - dq)) / max(float(np.sum(slope**2)), 1e-300))
        step = float(np.clip(step, -2.0 / this.rate, 2.0 / this.rate))
        lag += step
        if abs(step) < RESOLVED_S:
            break
    return lag


def _covered(this: Posture, other: Posture, lag: float) -> tuple[int, int]:
    time = this.time + lag
    inside = np.flatnonzero((time >= -RESOLVED_S) & (time <= other.time[-1] + RESOLVED_S))
    return (int(inside[0]), int(inside[-1]) + 1) if inside.size else (0, len(this.time))
