"""From a log to what the equations take: filtered alike on both sides, differentiated, on actuator axes, decimated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from exogauge.effects.effect import JointSignals
from exogauge.errors import BadLog, Fault
from exogauge.identification.added_columns import load_entries, zeros
from exogauge.identification.smear import smeared
from exogauge.identification.turns import WIDEST, RestDetection, TurnsOf
from exogauge.logs.bandwidth import suggest_cutoff
from exogauge.logs.derivatives import differentiate, differentiate_twice
from exogauge.logs.filtering import LowPass
from exogauge.logs.model import Log
from exogauge.logs.noise import noise_of
from exogauge.logs.segments import around, widened
from exogauge.robots.description import Robot, WrenchSensor
from exogauge.robots.motion import Motion
from exogauge.robots.rows import RowType
from exogauge.side_by_side import each as side_by_side

Array = NDArray[np.float64]

BASE_CHANNELS = ("base.fx", "base.fy", "base.fz", "base.mx", "base.my", "base.mz")
DRIVE = {"current": "i", "torque": "tau"}  # channel by which a joint's actuation is logged
TURNING = 1.5  # times its noise: a gyro that varies by more turns
# second only, and of what that does to a low-passed step less than a tenth is left by then
GYRO_SHARE = (
    0.5  # of the cut-off with the least error of the gyro's derivative: noise in a regressor biases, loss hardly
)
EVERY = slice(None)


@final
@dataclass(frozen=True)
class View:
    """How effects see a log. added: (T, entries) of `Prepared.added`. All others (T, A), as in `JointSignals`."""

    drive: Array
    velocity: Array
    acceleration: Array
    direction: Array
    rest: Array
    added: Array

    def signals(self, samples: slice | NDArray[np.intp] = EVERY) -> list[JointSignals]:
        """Of every axis, contiguous, without a stick sign."""
        every = (self.drive, self.velocity, self.acceleration, self.direction, self.rest)
        by_axis = zip(*(np.ascontiguousarray(each[samples].T) for each in every), strict=True)
        return [JointSignals(u, v, a, sign, rest, np.zeros(len(u))) for u, v, a, sign, rest in by_axis]


@final
@dataclass(frozen=True)
class Prepared:
    """One log at its own rate, low-passed; A = J actuator axes, S contact sensors.

    low_pass: for what is computed from the log; with the one that the log had passed before it was stored, if any.
    motion: filtered and differentiated. drive: (T, A) [A, or N·m where torque is logged], filtered.
    axis_velocity, axis_acceleration: (T, A).
    direction: (T, A) sgn_ε of the axis velocity; rest: (T, A) 1 - |direction|; both through the filter that the drive
    passed, because a sign jumps where a low-passed torque cannot.
    steady: (T, A) bool, the axis moves at speed; not so at rest, while it creeps (`RestDetection.creeping`), and near
    stops and turns, where a joint may stick for longer than a low-passed velocity can show.
    wrenches: (T, S, 6) world on robot, in sensor frames, filtered.
    carried: (T, C, 6) what holds and moves the bodies beyond each sensor that carries some, in its frame, filtered.
    raw_direction: (T, A) int8 sgn_ε of the axis velocity, not filtered.
    stored_direction, stored_rest: (T, A) raw_direction and 1 - |raw_direction|, through what the drive had passed
    before it was stored; None where it had passed nothing.
    kept: samples that enter a fit (settled ends and `Log.left_out` left out, decimated).
    left_out: (T,) bool, samples that feel what happened in `Log.left_out`; no axis is steady there.
    smeared: (T, told rows) what the low-pass before the log was stored has made of the bodies' load (`smear`).
    added, raw_added: (T, entries) what each added coefficient takes off a row per unit (`Equations.entries`), filtered
    and not.
    taken_off: (T, A) [N·m] what a wear bears of each axis' load, filtered; None in a log without one. Effects that grow
    with the load or the motor's torque see what is left of them.
    """

    log: Log
    low_pass: LowPass
    motion: Motion
    drive: Array
    axis_velocity: Array
    axis_acceleration: Array
    direction: Array
    rest: Array
    steady: NDArray[np.bool_]
    wrenches: Array
    raw_direction: NDArray[np.int8]
    stored_direction: Array | None
    stored_rest: Array | None
    carried: Array
    kept: NDArray[np.intp]
    left_out: NDArray[np.bool_]
    smeared: Array
    added: Array = field(default_factory=lambda: np.zeros((0, 0)))
    raw_added: Array = field(default_factory=lambda: np.zeros((0, 0)))
    taken_off: Array | None = None

    @property
    def settled(self) -> NDArray[np.bool_]:
        """(T,) not the ends of the log, where the low-pass leans on what was never measured."""
        inside = np.zeros(self.log.samples, dtype=bool)
        if self.kept.size:
            inside[self.kept[0] : self.kept[-1] + 1] = True
        return inside

    def with_added(self, filtered: Array, raw: Array) -> Prepared:
        """With further columns of what is added to its rows, (T, entries) each."""
        added, raw_added = np.hstack([self.added, filtered]), np.hstack([self.raw_added, raw])
        return replace(self, added=added, raw_added=raw_added)

    def at_kept(self) -> Prepared:
        """The kept samples alone; the log stays whole."""
        arrays = {name: each for name, each in vars(self).items() if isinstance(each, np.ndarray) and name != "kept"}
        some: dict[str, Any] = {name: each[self.kept] for name, each in arrays.items()}
        return replace(self, motion=self.motion.rows(self.kept), kept=np.arange(len(self.kept)), **some)

    @property
    def low_passed(self) -> View:
        return View(self.drive, self.axis_velocity, self.axis_acceleration, self.direction, self.rest, self.added)

    def as_stored(self, robot: Robot) -> View:
        """With the drive, the signs and the added columns as they are without the common low-pass."""
        direction, rest = self.stored_direction, self.stored_rest
        if direction is None or rest is None:
            direction = self.raw_direction.astype(np.float64)
            rest = 1.0 - np.abs(direction)
        drive = drive_on_axes(robot, self.log)
        return replace(self.low_passed, drive=drive, direction=direction, rest=rest, added=self.raw_added)


def needed_channels(robot: Robot) -> tuple[str, ...]:
    """Names of the channels without which `robot` cannot be identified."""
    names = [f"q.{joint.name}" for joint in robot.joints]
    names += [f"{DRIVE[joint.actuation]}.{joint.name}" for joint in robot.joints if joint.actuation != "none"]
    if robot.floating:
        names += [f"{kind}.{axis}" for kind in ("acc", "gyro") for axis in "xyz"]
    names += [name for sensor in robot.sensors for name in wrench_channels(sensor.name)]
    return tuple(names)


def wrench_channels(sensor: str) -> tuple[str, ...]:
    return tuple(f"ft.{sensor}.{axis}" for axis in ("fx", "fy", "fz", "mx", "my", "mz"))


def channel_of_row(robot: Robot, number: int) -> str:
    """Of the base wrench, a joint's torque, or a sensor's reading."""
    row = robot.rows.rows[number]
    if row.type == RowType.SENSOR:
        return wrench_channels(robot.cuts[row.place].name)[row.component]
    return BASE_CHANNELS[row.component] if row.type == RowType.BASE else f"tau.{robot.joints[row.place].name}"


def suggested_cutoffs(robot: Robot, logs: Sequence[Log]) -> list[float]:
    """[Hz] of each log the cut-off that it calls for: what its positions can bear, and its gyro."""
    names = [f"q.{joint.name}" for joint in robot.joints]

    def of_log(log: Log) -> float:
        bearable = [suggest_cutoff(log.stack(names), log.rate_hz)]
        gyro = log.stack(["gyro.x", "gyro.y", "gyro.z"]) if robot.floating else np.zeros((log.samples, 0))
        noise = np.array([each.std for each in noise_of(list(gyro.T), log.rate_hz, 0.25 * log.rate_hz)])
        if np.any(
            gyro.std(axis=0) > TURNING * noise
        ):  # a base that stands still says nothing of the motion's bandwidth
            bearable.append(GYRO_SHARE * suggest_cutoff(gyro, log.rate_hz, order=1))
        return min(bearable)

    return list(side_by_side(of_log, logs))


def prepare(robot: Robot, log: Log, cutoff_hz: float, at_rest: RestDetection) -> Prepared:
    """Filter, differentiate, transform to the base link and to the actuator axes.

    A part of a recording is filtered with what lies beside it. Its own ends count as unsettled all the same: what added
    effects do to a part is filtered without.
    """
    require_even_clock(log, at_rest.criteria.longest_step)
    missing = [name for name in needed_channels(robot) if not log.has(name)]
    if missing:
        advice = "Add the column, or describe the robot without it in robot.yaml."
        raise BadLog([Fault("this column is missing", "missing_channel", advice, log.name, column=m) for m in missing])
    if cutoff_hz > WIDEST * log.rate_hz:
        detail = f"{log.rate_hz:.4g} Hz is too slow for the cut-off of {cutoff_hz:.3g} Hz that the other logs call for"
        advice = f"Log at {cutoff_hz / WIDEST:.0f} Hz or more, or set a lower cutoff_hz."
        raise BadLog(Fault(detail, "rate_too_low", advice, log.name, column="t"))
    low_pass = LowPass(cutoff_hz, log.rate_hz)
    wide, own = widened(log)

    def filtered_wrenches(sensors: Sequence[WrenchSensor]) -> Array:
        raw = wrenches(sensors, wide)
        return low_pass.apply(raw.reshape(wide.samples, -1)).reshape(raw.shape)

    names = [joint.name for joint in robot.joints]
    raw_q = wide.stack([f"q.{name}" for name in names])
    q = low_pass.apply(raw_q)
    dq, ddq = differentiate(q, log.rate_hz), differentiate_twice(q, log.rate_hz)
    acc, gyro, gyro_dot = base_motion(robot, wide, low_pass)
    turns = TurnsOf(robot, wide, at_rest).behind(log.stored)
    alike = replace(low_pass, stored=log.stored)
    smooth_direction = low_pass.apply(turns.stored_direction)
    recovery = round(at_rest.criteria.recovery * log.rate_hz / cutoff_hz)
    axis_velocity, axis_acceleration = robot.on_axes(dq), robot.on_axes(ddq)
    settle = min(_settle_samples(log, low_pass), log.samples // 10)
    kept, left_out = np.arange(settle, log.samples - settle, low_pass.decimation()), left_out_samples(log, alike)
    turning = (np.abs(smooth_direction) < at_rest.criteria.steady) | (np.abs(axis_velocity) < at_rest.creeping)
    turning = around(turning, recovery)
    starting = round(at_rest.criteria.starting * log.rate_hz / cutoff_hz)
    turning |= around(turns.direction == 0.0, starting)
    motion = Motion(q, dq, ddq, acc, gyro, gyro_dot)
    added = np.hstack([zeros(robot, log.samples), load_entries(robot, log.recording, motion.rows(own))])
    return Prepared(
        log=log,
        low_pass=alike,
        motion=motion.rows(own),
        drive=low_pass.apply(drive_on_axes(robot, wide))[own],
        axis_velocity=axis_velocity[own],
        axis_acceleration=axis_acceleration[own],
        direction=smooth_direction[own],
        rest=low_pass.apply(turns.stored_rest)[own],
        steady=~(turning[own] | left_out[:, None]),
        wrenches=filtered_wrenches(robot.contacts)[own],
        raw_direction=turns.direction[own].astype(np.int8),
        stored_direction=None if log.stored is None else turns.stored_direction[own],
        stored_rest=None if log.stored is None else turns.stored_rest[own],
        carried=-filtered_wrenches(robot.cuts)[own],
        kept=kept[~left_out[kept]],
        left_out=left_out,
        added=added,
        raw_added=added,
        smeared=smeared(robot, wide, low_pass, motion)[own],
    )


def left_out_samples(log: Log, low_pass: LowPass) -> NDArray[np.bool_]:
    """(T,) within `Log.left_out`, or so near that the low-pass carries it there."""
    near = _settle_samples(log, low_pass) / log.rate_hz
    found = np.zeros(log.samples, dtype=bool)
    for start, stop in log.left_out:
        found |= (log.time > start - near) & (log.time < stop + near)
    return found


def _settle_samples(log: Log, low_pass: LowPass) -> int:
    """Of the slower of both low-passes, the one before the log was stored and this."""
    return max(low_pass.settle_samples, log.stored.settle_samples(log.rate_hz) if log.stored else 0)


def require_even_clock(log: Log, longest_step: float) -> None:
    """Derivatives need a clock without gaps. longest_step: in nominal ones."""
    step = np.diff(log.time)
    nominal = float(np.median(step))
    late = np.flatnonzero(step > longest_step * nominal)
    if late.size:
        row = int(late[0]) + 2
        detail = f"{late.size} gaps in time; the first lasts {step[late[0]]:.6g} s where {nominal:.6g} s is usual"
        raise BadLog(Fault(detail, "time_gap", "Cut the log at its gaps or resample it.", log.name, row, "t"))


def drive_on_axes(robot: Robot, log: Log) -> Array:
    """(T, A) not filtered: motor currents belong to axes already; joint torques are brought there by C^{-T}."""
    drive = np.zeros((log.samples, len(robot.joints)))
    torque = np.array([joint.actuation == "torque" for joint in robot.joints])
    for index, joint in enumerate(robot.joints):
        if joint.actuation != "none":
            drive[:, index] = log.channels[f"{DRIVE[joint.actuation]}.{joint.name}"]
    if torque.any():
        to_axes = np.linalg.inv(robot.axes_from_joints)
        drive[:, torque] = drive[:, torque] @ to_axes[np.ix_(torque, torque)]
    return drive


def wrenches(sensors: Sequence[WrenchSensor], log: Log) -> Array:
    """(T, S, 6) as `Prepared.wrenches`, not filtered."""
    found = np.zeros((log.samples, len(sensors), 6))
    for index, sensor in enumerate(sensors):
        found[:, index] = sensor.sign * log.stack(wrench_channels(sensor.name))
    return found


def base_motion(robot: Robot, log: Log, low_pass: LowPass) -> tuple[Array, Array, Array]:
    """Proper acceleration of the base link's origin, angular velocity and acceleration, in the base frame (T, 3)."""
    if robot.T_base_imu is None:
        still = np.zeros((log.samples, 3))
        return np.tile([0.0, 0.0, 9.81], (log.samples, 1)), still, still
    R, r = robot.T_base_imu.rotation, robot.T_base_imu.translation
    gyro = low_pass.apply(log.stack(["gyro.x", "gyro.y", "gyro.z"])) @ R.T
    f_imu = low_pass.apply(log.stack(["acc.x", "acc.y", "acc.z"])) @ R.T
    gyro_dot = differentiate(gyro, log.rate_hz)
    acc = f_imu - np.cross(gyro_dot, r) - np.cross(gyro, np.cross(gyro, r))
    return acc, gyro, gyro_dot
