"""A few moments of a log, spread over it: enough to ask whether what was measured fits the robot's description."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.examining import Comparing
from exogauge.identification.preparation import DRIVE, base_motion, needed_channels, wrench_channels
from exogauge.identification.prior import joint_prior
from exogauge.identification.turns import way_since_turn
from exogauge.logs.bandwidth import suggest_cutoff
from exogauge.logs.derivatives import differentiate, differentiate_twice
from exogauge.logs.filtering import LowPass
from exogauge.logs.findings import runs
from exogauge.logs.model import Log
from exogauge.logs.resampling import is_even
from exogauge.plausibility.axis_fit import in_motion
from exogauge.robots.description import Robot
from exogauge.robots.motion import Motion

Array = NDArray[np.float64]
# of a snapshot, along the first axis
MOMENTS = ("q", "dq", "ddq", "way", "ahead", "held", "acc", "gyro", "gyro_dot", "effort", "wrenches")


@final
@dataclass(frozen=True)
class Snapshot:
    """N moments of one log, low-passed; J joints, S contact sensors.

    q, dq, ddq: (N, J). way, ahead: (N, J) that a joint went since it last turned, and goes until it turns again.
    held: (N, J) bool, its position stays at one number for long.
    acc, gyro, gyro_dot: (N, 3) of the base link's origin, in its frame.
    effort: (N, J) [N·m] torque as logged, or the a-priori k_T times the current; 0 where a joint logs none.
    late: (LAGS, N, J) the same, from so much later; lags: (LAGS,) [s].
    late_imu: (LAGS, 3, N, 3) acc, gyro, gyro_dot, from so much later.
    wrenches: (N, S, 6) world on robot, in sensor frames. late_wrenches: (LAGS, N, S, 6) the same, from so much later.
    alive: (J,) bool, an effort is logged and is not one number throughout.
    zeros: (J,) share of exact zeros among a logged effort's samples in motion. still: (J,) bool, the position is one
    number throughout. recording: that the log is, or is a stretch of. criteria: by which it is compared.
    """

    log: str
    q: Array
    dq: Array
    ddq: Array
    way: Array
    ahead: Array
    held: NDArray[np.bool_]
    acc: Array
    gyro: Array
    gyro_dot: Array
    effort: Array
    late: Array
    lags: Array
    late_imu: Array
    wrenches: Array
    late_wrenches: Array
    alive: NDArray[np.bool_]
    zeros: Array
    still: NDArray[np.bool_]
    rate_hz: float
    recording: str
    criteria: Comparing

    @property
    def motion(self) -> Motion:
        return Motion(self.q, self.dq, self.ddq, self.acc, self.gyro, self.gyro_dot)

    def every(self, step: int) -> Snapshot:
        """Of the moments one in `step`."""
        some = {name: getattr(self, name)[::step] for name in MOMENTS}
        return replace(
            self,
            late=self.late[:, ::step],
            late_imu=self.late_imu[:, :, ::step],
            late_wrenches=self.late_wrenches[:, ::step],
            **some,
        )


def take(robot: Robot, log: Log, criteria: Comparing) -> Snapshot | None:
    """None where channels are missing or hold no number, or the log is too short to be low-passed."""
    moments = 100  # of a log: with more, neighbours say the same, and the whole has to cost well under a second
    names = needed_channels(robot)
    if not log.has(*names) or log.samples < 50 or not all(np.isfinite(log.channels[name]).all() for name in names):
        return None
    rate, joints, recording = log.rate_hz, robot.joints, log.recording
    if not is_even(log.time):
        even = np.arange(log.time[0], log.time[-1], 1.0 / rate)
        log = Log(log.name, even, {name: np.interp(even, log.time, log.channels[name]) for name in names})
    q = log.stack([f"q.{joint.name}" for joint in joints])
    hz = float(np.clip(suggest_cutoff(q, rate), criteria.slowest_hz, criteria.fastest_hz))
    low_pass = LowPass(min(hz, 0.2 * rate), rate)
    settle = low_pass.settle_samples
    if len(q) < 4 * settle:
        return None
    at = np.linspace(settle, len(q) - 1 - settle, moments).astype(np.intp)
    still, held, q = np.ptp(q, axis=0) == 0.0, held_positions(q, criteria.held), low_pass.apply(q)
    dq, ddq = differentiate(q, rate), differentiate_twice(q, rate)
    effort, alive, zeros = np.zeros_like(q), np.zeros(len(joints), dtype=bool), np.zeros(len(joints))
    moving = in_motion(dq, criteria)
    for k, joint in enumerate(joints):
        if joint.actuation != "none":
            raw = log.channels[f"{DRIVE[joint.actuation]}.{joint.name}"]
            effort[:, k], alive[k] = low_pass.apply(raw) * joint_prior(joint, "k_T"), np.ptp(raw) > 0.0
            zeros[k] = np.mean(raw[moving[:, k]] == 0.0) if moving[:, k].any() else 0.0
    far = min(round(criteria.delay_latest_s * rate), len(q) // 10)
    steps = _shifts(round(criteria.delay_far_s * rate), settle, far)
    imu = np.stack(base_motion(robot, log, low_pass))
    acc, gyro, gyro_dot = imu[:, at]
    read = [sensor.sign * low_pass.apply(log.stack(wrench_channels(sensor.name))) for sensor in robot.contacts]
    wrenches = np.stack(read, axis=1) if read else np.zeros((len(q), 0, 6))
    shifted = [np.clip(at + step, 0, len(q) - 1) for step in steps]
    return Snapshot(
        log=log.name,
        q=q[at],
        dq=dq[at],
        ddq=ddq[at],
        way=way_since_turn(q, dq)[at],
        ahead=way_since_turn(q[::-1], dq[::-1])[::-1][at],
        held=held[at],
        acc=acc,
        gyro=gyro,
        gyro_dot=gyro_dot,
        effort=effort[at],
        late=np.stack([effort[each] for each in shifted]),
        lags=steps / rate,
        late_imu=np.stack([imu[:, each] for each in shifted]),
        wrenches=wrenches[at],
        late_wrenches=np.stack([wrenches[each] for each in shifted]),
        alive=alive,
        zeros=zeros,
        still=still,
        rate_hz=rate,
        recording=recording,
        criteria=criteria,
    )


def held_positions(q: Array, share: float) -> NDArray[np.bool_]:
    """(T, J) samples of a run at one number, as long as this share of the log."""
    held = np.zeros(q.shape, dtype=bool)
    for own, values in zip(held.T, q.T, strict=True):
        starts, lengths = runs(np.abs(np.diff(values)) <= 1e-9 * max(float(np.ptp(values)), 1e-9))  # as resampled
        for start, length in zip(starts, lengths, strict=True):
            own[start : start + length + 1] |= length >= share * (len(values) - 1)
    return held


def _shifts(latest: int, settle: int, most: int) -> NDArray[np.intp]:
    """Samples: some within what a drive and a bus are late by at the latest; beyond, another clock's."""
    lags, ratio = 13, 1.25
    near = min(latest, settle)
    steps = [*np.linspace(-near, near, lags)]
    far = near * ratio
    while near == latest and far <= most:
        steps += [-far, far]
        far *= ratio
    return np.unique(np.round(steps).astype(np.intp))
