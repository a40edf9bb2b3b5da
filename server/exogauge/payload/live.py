"""Live: samples in, the contact wrench a tenth of a second later out, and ten times a second what is known by now.

The same smoother, rows, recursion and compensation as for logs. What comes out does not depend on how many samples came
at once.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal, final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.criteria import USUAL, Criteria
from exogauge.payload.calibration import Calibration, said_of
from exogauge.payload.contact import Compensation, false_alarm_limit, zero_helps, zero_of
from exogauge.payload.dynamics import Prior, Rows, dynamic_rows, reading_of_mu
from exogauge.payload.live_fit import Estimate, LiveFit, between_delay_and_pole, exciting
from exogauge.payload.live_track import Pose, Track, Tracked
from exogauge.payload.sensor_motion import SensorMotion, joined

Array = NDArray[np.float64]
Zero = Literal["none", "taking", "held", "beyond", "refused"]


@final
@dataclass(frozen=True)
class Start:
    """What is known when a stream begins. gravity: (3,) [m/s²] in {B}. sign: s. std: (6,) [N, N·m] of one wrench.
    believed: (16,) std of x of a payload of which nothing is known. late: [s] by which wrenches are late,
    and its std, where logs say it; filtered: [s²] variance of the response of what delays them, and its std.
    calibration: of the sensor, by what logs read. memory: samples at rest that count as one. in_doubt: why what is told
    live is not to be believed, as logs say. in_motion: whether logs in motion were looked at for a delay."""

    pose: Pose
    gravity: Array
    sign: int
    std: Array
    prior: Prior
    believed: Array
    false_alarms_per_hour: float = 1.0
    criteria: Criteria = USUAL
    late: tuple[float, float] | None = None
    filtered: tuple[float, float] | None = None
    calibration: Calibration | None = None
    memory: float = 1.0
    in_doubt: tuple[str, ...] = ()
    in_motion: bool = True


@final
@dataclass(frozen=True)
class Sensed:
    """Of T samples. time: [s]. wrench: (T, 6) of the environment on the payload, in {S}, about its origin, after the
    secondary zero where that is held. std: (T, 6) of it without contact. alarm: more than that, by the stated rate.
    settled: False after a start or a gap, when nothing is told. zero: of the last sample."""

    time: Array
    wrench: Array
    std: Array
    alarm: NDArray[np.bool_]
    settled: NDArray[np.bool_]
    zero: Zero


@final
@dataclass(frozen=True)
class Known:
    """At `time` [s]. threshold: [N] force that counts as contact in this posture, in its least certain direction.
    left_out: samples in or beside an alarm, which were not used. late: [s] by which wrenches are late, and its std,
    which is taken off; None where they are not, as far as is known. in_doubt: why the estimate is not to be believed:
    sentences. calibration: what every std holds of the sensor's; empty where it is exact."""

    time: float
    estimate: Estimate
    threshold: float
    left_out: int
    late: tuple[float, float] | None = None
    in_doubt: tuple[str, ...] = ()
    calibration: str = ""


@final
class Live:
    """One stream."""

    def __init__(self, start: Start, rate_hz: float = 250.0, *, still: Literal["settled", "as_moving"] = "settled"
                 ) -> None:  # fmt: skip
        self.start, self.rate_hz = start, rate_hz
        says = self._says = start.criteria.payload_live
        farthest = start.criteria.payload.latest_s
        self.track = Track(start.pose, rate_hz, start.gravity, still=still, criteria=says, farthest_s=farthest)
        self.track.retimed.late = 0.0 if start.late is None else start.late[0]
        self.fit = self._begun(named=start.late is not None)
        self._told_late = start.late
        self._calibration = "" if start.calibration is None else said_of(start.calibration)
        self.limit = false_alarm_limit(start.false_alarms_per_hour / 3600.0 / rate_hz)
        self.given = 0  # samples that came out
        self.left_out = 0
        self._every = max(round(rate_hz / says.estimates_hz), 1)
        self._before, self._after = round(says.before_s * rate_hz), round(says.after_s * rate_hz)
        self._barred = 0  # samples that are still beside an alarm
        self._released = 0  # samples that wait no longer
        self._last_used = -round(says.lately_s * rate_hz) - 1
        self._thawed = 0  # samples used since the estimate was frozen
        self._wrench = np.zeros((0, 6))
        self._held = Held(
            np.zeros((0, 6, 17)), np.zeros((0, 6, 10)), np.zeros((0, 17, 17)), np.zeros((0, 3, 2)),
            np.zeros(0, bool), np.zeros(0, bool),
        )  # fmt: skip
        self._unlearned = list[tuple[SensorMotion, Array, NDArray[np.bool_], NDArray[np.bool_]]]()
        self._last_time = np.nan
        self._zero = SecondZero(start.gravity, round(start.criteria.payload_dynamic.zero_s * rate_hz), start.criteria)
        self._compensation = self._compensated(self.fit.estimate(False))

    @property
    def told(self) -> bool:
        """Whether so many samples came out that it was told what is known."""
        return self.given >= self._every

    def zero(self) -> None:
        """Take a secondary zero from the next half second, in which nothing may touch the payload."""
        self._zero.begin()

    def push(self, time: Array, values: Array, wrench: Array) -> Iterator[Sensed | Known]:
        """time: (n,) [s], increasing, also over calls. values: (n, K) joint angles [rad], or R_BS row by row and the
        position [m]. wrench: (n, 6) as read, in {S}."""
        if self.start.calibration is not None:
            wrench = self.start.calibration.corrected(wrench)
        before = np.concatenate([[self._last_time], time[:-1]])
        gaps = np.flatnonzero(time - before > (self._says.longest_gap + 0.5) / self.rate_hz)
        if len(time):
            self._last_time = time[-1]
        edges = [0, *gaps.tolist(), len(time)]
        for first, last in pairwise(edges):
            if first in gaps:
                yield from self.flush()
            while first < last:
                here = min(last, first + self._every - self.given % self._every)
                self._wrench = np.concatenate([self._wrench, wrench[first:here]])
                yield from self._given(self.track.push(time[first:here], values[first:here]))
                first = here

    def flush(self) -> Iterator[Sensed | Known]:
        """What has not come out yet: at the end, or before a gap."""
        left = self.track.flush()
        for first in range(0, len(left.settled), self._every):  # not more than one estimate for each
            yield from self._given(left.rows(slice(first, first + self._every)))

    def _given(self, tracked: Tracked) -> Iterator[Sensed | Known]:
        motion, settled, n = tracked.motion, tracked.settled, len(tracked.settled)
        if n == 0:
            return
        wrench, self._wrench = self._wrench[:n], self._wrench[n:]
        touched = self._compensation.touched(motion, wrench, self.limit)
        alarm = touched.alarm & settled
        external, zero = self._zero.applied(motion, touched.external, alarm, settled)
        std = np.sqrt(np.diagonal(touched.spread, axis1=1, axis2=2))
        yield Sensed(motion.time, -self.start.sign * external, std, alarm, settled, zero)
        self._unlearned.append((motion, wrench, alarm, settled & tracked.noise_known))
        before, self.given = self.given, self.given + n
        if self.given // self._every > before // self._every:  # who waits for the wrench has it
            motions, wrenches, alarms, trusted = zip(*self._unlearned, strict=True)
            self._unlearned = []
            self._learn(joined(motions), np.concatenate(wrenches), np.concatenate(alarms), np.concatenate(trusted))
            if self._released - self._last_used > self._says.lately_s * self.rate_hz:
                self._thawed = 0
            estimate = self.fit.estimate(self._thawed > self._says.thaws_s * self.rate_hz)
            self._compensation = self._compensated(estimate)
            force = touched.spread[-1, :3, :3]
            threshold = float(np.sqrt(self.limit * np.linalg.eigvalsh(force)[-1]))
            self._told_late = self._late(estimate)
            yield Known(
                float(motion.time[-1]), self.fit.doubted(estimate), threshold, self.left_out, self._told_late,
                self._in_doubt(estimate), self._calibration,
            )  # fmt: skip

    def _begun(self, *, named: bool) -> LiveFit:
        start = self.start
        fit = LiveFit(
            start.prior, start.believed, start.criteria, named=named, calibration=start.calibration,
            memory=start.memory, filtered=start.filtered, in_motion=start.in_motion,
        )  # fmt: skip
        if named and start.filtered is None:
            fit.filtered = between_delay_and_pole(self.track.retimed.late)
        return fit

    def _in_doubt(self, estimate: Estimate) -> tuple[str, ...]:
        said = list(self.start.in_doubt)
        if self.left_out > max(self._says.barred_s * self.rate_hz, estimate.used):
            said.append(
                "Most of the motion is in alarm and teaches nothing: something rests on the payload, or it is another "
                "one, or the sensor's zero is another than before. Stop in postures anew, or take the zero."
            )
        off = self.fit.contradiction(estimate)
        if off > self._says.contradicts:
            said.append(
                f"Motion says by {off:.2g} standard deviations another thing than before: the payload was changed or "
                "has shifted, something rests on it, or the sensor's zero moves. Stop in postures anew."
            )
        if estimate.mu is not None and estimate.mu_std is not None and estimate.mu >= 1.0:
            reading = reading_of_mu(estimate.mu, estimate.mu_std, criteria=self.start.criteria.payload_dynamic)
            said += [] if reading is None else [reading]
        return tuple(said)

    def _late(self, estimate: Estimate) -> tuple[float, float] | None:
        """By how much wrenches are late. Where that is more than chance it is taken off from now on, and the fit begins
        anew where it was taken by too much of it for a straight line."""
        more = self.fit.late_of_barred() or estimate.late
        if more is not None and abs(more[0]) > self.start.criteria.payload_dynamic.mu_stds * more[1]:
            self.fit.named = True
            if self.start.filtered is None:
                self.fit.filtered = between_delay_and_pole(self.track.retimed.late + more[0])
            retimed, most = self.track.retimed, self.start.criteria.payload.latest_s
            if abs(more[0]) > self._says.straight_s:
                retimed.late = float(np.clip(retimed.late + more[0], -most, most))
                self.fit, self.left_out = self._begun(named=True), 0
                return retimed.late, more[1]
        if not self.fit.named or more is None:
            return self._told_late
        return self.track.retimed.late + more[0], more[1]

    def _learn(self, motion: SensorMotion, wrench: Array, alarm: NDArray[np.bool_], trusted: NDArray[np.bool_]) -> None:
        """Rows wait until it is known that no alarm follows them."""
        start = self.start
        rows = dynamic_rows(motion, wrench, start.gravity, start.sign, start.std)
        barred, alarms = alarm.copy(), np.flatnonzero(alarm)
        barred[: self._barred] = True
        for k in alarms:
            barred[k : k + self._after + 1] = True
            self._barred = int(k) + self._after + 1
        self._barred = max(self._barred - len(alarm), 0)
        assert rows.tipped is not None
        body = rows.z[:, :, :10]
        rates = np.gradient(body, motion.time, axis=0) if len(body) > 1 else np.zeros_like(body)
        use = trusted & exciting(rows, self._says)
        held = self._held.then(Held(rows.z, rates, rows.noise, rows.tipped, barred, use))
        for k in alarms:
            at = len(held.barred) - len(alarm) + k
            held.barred[max(at - self._before, 0) : at] = True
        ripe = max(len(held.barred) - self._before, 0)
        use = held.exciting[:ripe] & ~held.barred[:ripe]
        left_out = held.exciting[:ripe] & held.barred[:ripe]
        self.left_out += int(np.sum(left_out))
        if left_out.any():
            self.fit.of_barred(replace(rows, z=held.z[:ripe][left_out]), held.rates[:ripe][left_out])
        if use.any():
            self.fit.take(
                Rows(held.z[:ripe][use], held.noise[:ripe][use], start.std, start.sign, held.tipped[:ripe][use]),
                held.rates[:ripe][use],
            )
            self._last_used = self._released + int(np.flatnonzero(use)[-1])
            self._thawed += int(use.sum())
        self._released += ripe
        self._held = held.after(ripe)

    def _compensated(self, estimate: Estimate) -> Compensation:
        start = self.start
        return Compensation(estimate.value, estimate.covariance, start.gravity, start.sign, start.std)


@final
@dataclass(frozen=True)
class Held:
    """Rows that wait."""

    z: Array
    rates: Array
    noise: Array
    tipped: Array
    barred: NDArray[np.bool_]
    exciting: NDArray[np.bool_]

    def then(self, more: Held) -> Held:
        return Held(
            np.concatenate([self.z, more.z]), np.concatenate([self.rates, more.rates]),
            np.concatenate([self.noise, more.noise]), np.concatenate([self.tipped, more.tipped]),
            np.concatenate([self.barred, more.barred]), np.concatenate([self.exciting, more.exciting]),
        )  # fmt: skip

    def after(self, k: int) -> Held:
        return Held(
            self.z[k:], self.rates[k:], self.noise[k:], self.tipped[k:], self.barred[k:], self.exciting[k:]
        )  # fmt: skip


@final
class SecondZero:
    """[Payload] (44), as `contact.second_zero`, begun when asked. Refused where an alarm falls into its half second."""

    def __init__(self, gravity: Array, samples: int, criteria: Criteria = USUAL) -> None:
        self._gravity, self._samples, self._criteria = gravity, samples, criteria.payload_dynamic
        self._state: Zero = "none"
        self._external, self._rotation = np.zeros((0, 6)), np.zeros((0, 3, 3))
        self._mean, self._then = np.zeros(6), np.zeros(3)

    def begin(self) -> None:
        self._state = "taking"
        self._external, self._rotation = np.zeros((0, 6)), np.zeros((0, 3, 3))

    def applied(
        self, motion: SensorMotion, external: Array, alarm: NDArray[np.bool_], settled: NDArray[np.bool_]
    ) -> tuple[Array, Zero]:
        if self._state == "taking":
            self._external = np.concatenate([self._external, external[settled]])
            self._rotation = np.concatenate([self._rotation, motion.rotation[settled]])
            if alarm.any():
                self._state = "refused"
            elif len(self._external) >= self._samples:
                self._mean, self._then = zero_of(self._rotation, self._external, self._gravity)
                self._state = "held"
            return external, self._state
        if self._state in ("none", "refused"):
            return external, self._state
        helps = zero_helps(motion.rotation, self._then, self._gravity, self._criteria)
        return np.where(helps[:, None], external - self._mean, external), "held" if helps[-1] else "beyond"
