"""What touches the payload: the wrench that is left when its weight and inertia are taken out; in logs of
contact with a zero of their own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri

from exogauge.criteria.criteria import Criteria
from exogauge.criteria.payload_dynamic import USUAL, Moving
from exogauge.loops.payload_rows import spread
from exogauge.payload.intake import Payload
from exogauge.payload.prepare import Moved
from exogauge.payload.sensor_motion import SensorMotion

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Compensation:
    """x: (16,) [m, m c, I, F_0] and its (16, 16) covariance; gravity (3,) [m/s²] in {B}; sign s; std (6,) of wrench.

    Implements [Payload] (1), (4), (44).
    """

    x: Array
    covariance: Array
    gravity: Array
    sign: int
    std: Array

    def external(self, motion: SensorMotion, wrench: Array) -> Array:
        """(T, 6) F_ext = F_raw - F_0 - s A Φ, as the sensor would read it. wrench: (T, 6) as read."""
        return self._left(motion, wrench)[0]

    def spread(self, motion: SensorMotion) -> Array:
        """(T, 6, 6) covariance of `external` without contact: noise of sensor and kinematics, parameters."""
        return self._left(motion, np.zeros((len(motion.time), 6)))[1]

    def _left(self, motion: SensorMotion, wrench: Array) -> tuple[Array, Array]:
        left, out = np.empty((len(wrench), 6)), np.empty((len(wrench), 6, 6))
        wrench, x, covariance = (np.ascontiguousarray(each) for each in (wrench, self.x, self.covariance))
        spread(*motion.arrays(self.gravity), wrench, x, covariance, self.std, float(self.sign), left, out)
        return left, out

    def touched(self, motion: SensorMotion, wrench: Array, limit: float) -> Touched:
        """What is left, and whether its force is more than noise. limit: of fᵀ C⁻¹ f."""
        external, C = self._left(motion, wrench)
        f = external[:, :3]
        square = np.einsum("ti,ti->t", f, np.linalg.solve(C[:, :3, :3], f[:, :, None])[:, :, 0])
        return Touched(external, C, square > limit)

    def force_threshold(self, motion: SensorMotion, false_alarms_per_sample: float) -> Array:
        """(T,) [N] force that counts as contact in its least certain direction."""
        largest = np.linalg.eigvalsh(self.spread(motion)[:, :3, :3])[:, -1]
        return np.asarray(np.sqrt(false_alarm_limit(false_alarms_per_sample) * largest))

    def contacts(
        self, motion: SensorMotion, wrench: Array, false_alarms_per_hour: float, criteria: Moving = USUAL
    ) -> list[tuple[float, float]]:
        """Spans (from, to) [s] in which the force is more than noise, so many of them wrong per hour."""
        return spans(motion.time, self._alarm(motion, wrench, false_alarms_per_hour), criteria.bridged_s)

    def pushes(
        self, motion: SensorMotion, wrench: Array, false_alarms_per_hour: float, criteria: Moving = USUAL
    ) -> list[tuple[float, float]]:
        """Those of `contacts` that alarm most of their time: who pushes goes on doing so. Single samples that jump,
        however often, are noise with heavy tails, and no push."""
        alarm = self._alarm(motion, wrench, false_alarms_per_hour)
        found = spans(motion.time, alarm, criteria.bridged_s)
        inside = [alarm[(motion.time >= a) & (motion.time <= b)] for a, b in found]
        return [span for span, own in zip(found, inside, strict=True) if np.mean(own) >= criteria.pushing]

    def _alarm(self, motion: SensorMotion, wrench: Array, false_alarms_per_hour: float) -> NDArray[np.bool_]:
        period = float(np.median(np.diff(motion.time)))
        limit = false_alarm_limit(false_alarms_per_hour * period / 3600.0)
        return self.touched(motion, wrench, limit).alarm


@final
@dataclass(frozen=True)
class Touched:
    """external: (T, 6) F_ext as the sensor would read it. spread: (T, 6, 6) its covariance without contact. alarm: (T,)
    whether the force is more than that."""

    external: Array
    spread: Array
    alarm: NDArray[np.bool_]


def false_alarm_limit(per_sample: float) -> float:
    """What fᵀ C⁻¹ f of three normal forces exceeds so often."""
    return float(chdtri(3, per_sample))


def second_zero(
    motion: SensorMotion, external: Array, gravity: Array, criteria: Moving = USUAL
) -> tuple[Array, NDArray[np.bool_]]:
    """(T, 6) F_ext minus its mean over the first half second, and (T,) where that still helps: gravity within 60°.

    Implements [Payload] (44), with an average in place of one sample.
    """
    first = motion.time <= motion.time[0] + criteria.zero_s
    mean, then = zero_of(motion.rotation[first], external[first], gravity)
    return external - mean, zero_helps(motion.rotation, then, gravity, criteria)


def zero_of(rotation: Array, external: Array, gravity: Array) -> tuple[Array, Array]:
    """(6,) mean of F_ext, and (3,) where gravity points meanwhile, in {S}."""
    down = np.einsum("tji,j->ti", rotation, gravity).mean(axis=0)
    return external.mean(axis=0), down / np.linalg.norm(down)


def zero_helps(rotation: Array, then: Array, gravity: Array, criteria: Moving = USUAL) -> NDArray[np.bool_]:
    """(T,) whether gravity points within 60° of where it did."""
    down = np.einsum("tji,j->ti", rotation, gravity / np.linalg.norm(gravity))
    return np.asarray(down @ then >= np.cos(np.radians(criteria.farthest_zero_deg)))


def spans(time: Array, flag: NDArray[np.bool_], bridged: float) -> list[tuple[float, float]]:
    """(from, to) of the runs of a flag, those closer than `bridged` [s] as one."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flag.astype(np.int8), [0]])))
    out: list[tuple[float, float]] = []
    for a, b in edges.reshape(-1, 2):
        start, end = float(time[a]), float(time[b - 1])
        if out and start - out[-1][1] <= bridged:
            out[-1] = (out[-1][0], end)
        else:
            out.append((start, end))
    return out


@final
@dataclass(frozen=True)
class Touch:
    """A contact: span [s], largest force of the environment on the payload (3,) [N] in {S}."""

    start: float
    end: float
    force: Array


def zeroed(
    payload: Payload, compensation: Compensation, contact: Sequence[Moved], moving: bool, criteria: Criteria
) -> tuple[list[Moved], list[str]]:
    """Logs of contact with a zero of their own taken off, where one constant is what alarms through most of a log, and
    other logs show that the zero moves; and what is said of it. moving: whether they do."""
    out, said, most = list[Moved](), list[str](), criteria.payload.touched
    limit = false_alarm_limit(criteria.payload_dynamic.zero_alarms)
    for recording, each in zip(payload.of("contact"), contact, strict=True):
        found = compensation.touched(each.motion, each.wrench, limit)
        constant = np.median(found.external, axis=0)
        without = replace(each, wrench=each.wrench - constant)
        share = float(np.mean(compensation.touched(each.motion, without.wrench, limit).alarm))
        if np.mean(found.alarm) < most or share > most * float(np.mean(found.alarm)):
            out.append(each)
            continue
        force = float(np.linalg.norm(constant[:3]))
        told = f"{recording.name}: {force:.3g} N stand there in {100 * np.mean(found.alarm):.0f} % of the time. "
        taken = "Other logs show a zero that moves: taken for that, and off."
        said.append(told + (taken if moving else "A zero that has moved looks like that, and so does a lasting touch."))
        out.append(without if moving else each)
    return out, said


def found_touches(
    payload: Payload, compensation: Compensation, contact: Sequence[Moved], sign: int, criteria: Criteria
) -> tuple[dict[str, tuple[Touch, ...]], dict[str, float]]:
    """Contacts by log, and the force [N] that counts as one."""
    touches: dict[str, tuple[Touch, ...]] = {}
    thresholds: dict[str, float] = {}
    for recording, touched in zip(payload.of("contact"), contact, strict=True):
        rate = payload.file.settings.false_alarms_per_hour
        external = compensation.external(touched.motion, touched.wrench)
        touches[recording.name] = tuple(
            _touch(span, touched.motion.time, -sign * external)
            for span in compensation.contacts(touched.motion, touched.wrench, rate, criteria.payload_dynamic)
        )
        period = float(np.median(np.diff(touched.motion.time)))
        limit = compensation.force_threshold(touched.motion, rate * period / 3600.0)
        thresholds[recording.name] = float(limit.max())
    return touches, thresholds


def _touch(span: tuple[float, float], time: Array, on_payload: Array) -> Touch:
    inside = on_payload[(time >= span[0]) & (time <= span[1]), :3]
    return Touch(span[0], span[1], inside[int(np.argmax(np.linalg.norm(inside, axis=1)))])
