"""What was recorded, made ready for the stages: postures, motion on one clock, rows below a cut-off."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.criteria import Criteria
from exogauge.criteria.payload_dynamic import USUAL as MOVING
from exogauge.criteria.payload_dynamic import Moving
from exogauge.criteria.payload_static import USUAL, Standing
from exogauge.errors import BadStudy, Fault, NotIdentifiable
from exogauge.logs.filtering import LowPass
from exogauge.payload.calibration import Declared
from exogauge.payload.contract import PayloadFile, Role, SensorUncertainty
from exogauge.payload.dynamics import Rows, dynamic_rows
from exogauge.payload.holds import find_holds
from exogauge.payload.imu import ImuFrame
from exogauge.payload.intake import Payload, Recording
from exogauge.payload.rounding import Rounding, rounded_mean
from exogauge.payload.sensor_motion import Carried, SensorMotion, from_joints, from_pose, rotations
from exogauge.payload.statics import Holds

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Moved:
    """A log on one clock. noise_known: every wrench is as it was measured, and its motion that of a smoother of
    known noise. Not with an IMU, whose noise nobody stated."""

    motion: SensorMotion
    wrench: Array
    noise_known: bool

    def rows(self, which: NDArray[np.bool_]) -> Moved:
        return replace(self, motion=self.motion.rows(which), wrench=self.wrench[which])


def stated_of(payload: Payload) -> Array:
    """(6,) [N, N·m] of one sample: as stated, or with the rounding of steps that are coarser than that."""
    noise = payload.file.sensor.noise
    stated = np.repeat([noise.force_n, noise.moment_nm], 3)
    size = np.max([np.zeros(6), *(each.steps.size for each in payload.recordings)], axis=0)
    return np.where(size > stated, np.hypot(stated, size / np.sqrt(12.0)), stated)


def std_of(payload: Payload, criteria: Moving = MOVING) -> Array:
    """(6,) [N, N·m] of one sample: as `stated_of`, of steps no more than logs show, but never less than stated; as
    shown where that is clearly more."""
    noise, stated = payload.file.sensor.noise, stated_of(payload)
    shown = np.max([np.zeros(6), *(each.steps.noise for each in payload.recordings)], axis=0)
    least = np.repeat([noise.force_n, noise.moment_nm], 3)
    seen = np.where(shown > 0.0, np.maximum(least, np.minimum(shown, stated)), stated)
    return np.where(shown > criteria.noisier * stated, shown, seen)


def shown_over_taken(payload: Payload, role: Role) -> float:
    """Mean over the channels of the variance that logs of a role show of a sample's noise, over that of `std_of`."""
    shown = np.max([np.zeros(6), *(each.steps.noise for each in payload.of(role))], axis=0)
    return float(np.mean((shown / std_of(payload)) ** 2))


def declared_of(file: PayloadFile, criteria: Criteria, *, contradicted: bool = False) -> Declared:
    """As payload.yaml says, else the defaults. contradicted: whether a gain or a crosstalk was named, so that a sensor
    that is said to be exact is none."""
    noise, said = file.sensor.noise, file.uncertainty
    length = noise.moment_nm / noise.force_n
    if said == "none":
        if not contradicted:
            return Declared(0.0, 0.0, 0.0, length)
        said = SensorUncertainty()
    usual = {
        "ft_gain": criteria.declared.ft_gain,
        "ft_gain_common": criteria.declared.ft_gain_common,
        "ft_crosstalk": criteria.payload_static.ft_crosstalk,
    }
    stated = said.model_dump()
    found = [usual[name] if stated[name] is None else float(stated[name]) for name in usual]
    gain, common, across = found
    return Declared(gain, common, across, length, frozenset(name for name in usual if stated[name] is None))


def holds_of(payload: Payload, criteria: Standing = USUAL) -> tuple[Holds, Array | None]:
    """Every posture of every log, and the IMU's mean in each, (K, 3), if there is one. Raises BadStudy."""
    rotation, wrench, acceleration, counts, spans = [], [], [], list[int](), list[tuple[float, float]]()
    differ, scatter, stamps = list[Array](), list[Array](), list[float]()
    for recording in payload.of("postures"):
        R, F, pose = recording.rotation, recording.wrench, recording.pose
        if recording.each_row:
            entries = rotations(payload.tree, payload.file.sensor.frame or "", pose.values) if payload.tree else None
            rotation += list(R.values.reshape(-1, 3, 3) if R else entries if entries is not None else [])
            wrench += list(F.values)
            counts += [1] * len(F.values)
            spans += [(float(k + 1), float(k + 1)) for k in range(len(F.values))]
            acceleration += list(recording.acceleration.values) if recording.acceleration else []
            continue
        for a, b in find_holds(pose.time, pose.values, payload.file.pose.noise_rad, criteria):
            inside, mean = F.cut(a, b), pose.cut(a, b).values.mean(axis=0)
            if len(inside.time) < 2:
                continue
            if payload.tree:
                rotation.append(rotations(payload.tree, payload.file.sensor.frame or "", mean[None])[0])
            else:
                U, _, Vt = np.linalg.svd(mean.reshape(3, 3))
                rotation.append(U @ Vt)
            wrench.append(inside.values.mean(axis=0))
            half = len(inside.time) // 2
            differ.append(inside.values[:half].mean(axis=0) - inside.values[half:].mean(axis=0))
            scatter.append(inside.values.std(axis=0, ddof=1))
            counts.append(len(inside.time))
            spans.append((a, b))
            stamps.append(recording.begun + (a + b) / 2)
            if recording.acceleration:
                acceleration.append(recording.acceleration.cut(a, b).values.mean(axis=0))
    if len(wrench) < 3:
        advice = "Hold the arm still for a second in each of at least six postures that differ in gravity."
        files = payload.of("postures")[0].wrench.file
        detail = f"{len(wrench)} postures were found in which nothing moved; at least three are needed"
        raise BadStudy(Fault(detail, "too_few_postures", advice, files, value=str(len(wrench))))
    R_BS, F_S = np.array(rotation), np.array(wrench)
    if payload.file.sensor.axes == "base":
        F_S = into_sensor(R_BS, F_S)
    std = std_of(payload) / np.sqrt(np.median(counts))
    steps = np.max([each.steps.size for each in payload.of("postures")], axis=0)
    within = np.median(scatter, axis=0) if scatter else np.zeros(6)
    before = np.sqrt(np.maximum(within**2 - steps**2 / 12.0, 0.0))
    std = np.hypot(std, [rounded_mean(*each) for each in zip(steps, before, strict=True)])
    unrest = np.sqrt(np.mean(np.square(differ), axis=0)) / 2 if len(differ) == len(F_S) else None
    if unrest is not None:  # noise that remembers: halves of a posture differ by more than white noise does by chance
        chance = criteria.unrest_stds / np.sqrt(2.0 * len(F_S))
        std = np.where(unrest > (1.0 + chance) * std, unrest, std)
    noise = within if scatter else None
    holds = Holds(
        R_BS,
        F_S,
        std,
        payload.file.pose.noise_rad,
        np.array(spans),
        unrest,
        noise,
        np.array(stamps) if scatter else None,
    )
    return holds, np.array(acceleration) if len(acceleration) == len(F_S) else None


def moving(
    payload: Payload, recording: Recording, gravity: Array, imu: ImuFrame | None, criteria: Moving = MOVING
) -> Moved:
    """The sensor's motion and the wrench (T, 6) in {S}, on one clock. gravity: (3,) [m/s²] in {B}."""
    pose, settings, wrench = payload.file.pose, payload.file.settings, recording.wrench
    first, time, values, position = wrench.time, recording.pose.time, recording.pose.values, recording.position
    carried = carried_of(payload, recording, criteria)
    if payload.tree is not None:
        at = None if np.array_equal(time, first) else first
        frame = payload.file.sensor.frame or ""
        motion = from_joints(
            payload.tree, frame, time, values, pose.noise_rad, gravity,
            density=settings.jerk_density, criteria=criteria, at=at,
        )  # fmt: skip
    elif position is not None:
        at = None if np.array_equal(time, first) and np.array_equal(position.time, first) else first
        motion = from_pose(
            time, values.reshape(-1, 3, 3), position.values, pose.noise_rad, pose.noise_m, gravity,
            density=settings.jerk_density, criteria=criteria, at=at, position_time=position.time,
        )  # fmt: skip
    elif carried is not None and imu is not None:
        at = first
        motion, _ = carried.motion(first, imu, gravity)
    else:
        detail = "without position, joint angles or an IMU nothing says how the sensor accelerates"
        advice = "Log the position of the sensor, or an IMU and postures that tell how it sits."
        raise BadStudy(Fault(detail, "no_acceleration", advice, recording.pose.file))
    read = wrench.values if at is None else wrench.values[np.isin(first, motion.time)]
    if payload.file.sensor.axes == "base":
        read = into_sensor(motion.rotation, read)
    if not len(motion.time):
        advice = "Record longer, or check `time.unit` and `span`."
        detail = "pose and wrench have too little time in common"
        raise BadStudy(Fault(detail, "clocks_apart", advice, recording.pose.file))
    inner = slice(motion.edge, len(motion.time) - motion.edge)
    return Moved(motion.inner(), read[inner], carried is None)


def carried_of(payload: Payload, recording: Recording, criteria: Moving = MOVING) -> Carried | None:
    """Of a log whose accelerations are those of an IMU; None where positions or joint angles tell them."""
    read, pose = recording.acceleration, recording.pose
    if payload.tree is not None or recording.position is not None or read is None:
        return None
    return Carried.of(
        pose.time, pose.values.reshape(-1, 3, 3), payload.file.pose.noise_rad, read.time, read.values, criteria
    )  # fmt: skip


def rows_of(
    payload: Payload,
    moved: Sequence[Moved],
    gravity: Array,
    sign: int,
    keep: Sequence[NDArray[np.bool_]] | None = None,
) -> Rows:
    """Of several logs, one after the other. keep: of each the samples that count, where nothing is low-passed."""
    std, cutoff_hz = std_of(payload), payload.file.settings.cutoff_hz
    parts = [
        low_passed(dynamic_rows(each.motion, each.wrench, gravity, sign, std), each.motion.time, cutoff_hz)
        for each in moved
    ]
    if keep is not None and cutoff_hz is None:
        parts = [part.rows(k) for part, k in zip(parts, keep, strict=True)]
    tipped = np.concatenate([p.tipped for p in parts if p.tipped is not None])
    shared = [p.common for p in parts if p.common is not None]
    common = None
    if shared:
        common = np.concatenate([np.zeros((len(p.z), *shared[0].shape[1:])) if p.common is None else p.common
                                 for p in parts])  # fmt: skip
    z, noise = (np.concatenate([getattr(p, name) for p in parts]) for name in ("z", "noise"))
    noise_said, sizes = payload.file.sensor.noise, [each.steps.size for each in payload.recordings]
    before = np.repeat([noise_said.force_n, noise_said.moment_nm], 3)
    return Rows(z, noise, std, sign, tipped, common, Rounding.of(np.max(sizes, axis=0), before))


def low_passed(rows: Rows, time: Array, cutoff_hz: float | None) -> Rows:
    """The same zero-phase filter on every column and on the wrench: it leaves the parameters where they are."""
    low_pass = low_pass_of(cutoff_hz, time)
    if low_pass is None:
        return rows
    edge = low_pass.settle_samples
    z = low_pass.apply(rows.z.reshape(len(time), -1)).reshape(rows.z.shape)[edge:-edge]
    noise = np.zeros((len(z), *rows.noise.shape[1:]))
    noise[:, -1, -1] = 6.0
    tipped, common = (
        None if each is None else low_pass.apply(each.reshape(len(time), -1))[edge:-edge].reshape(len(z), 3, -1)
        for each in (rows.tipped, rows.common)
    )
    return Rows(z, noise, rows.std, rows.sign, tipped, common)


def low_pass_of(cutoff_hz: float | None, time: Array) -> LowPass | None:
    """Raises NotIdentifiable where the log is too short for it."""
    rate = 1.0 / float(np.median(np.diff(time)))
    if cutoff_hz is None or cutoff_hz >= rate / 2:
        return None
    low_pass = LowPass(cutoff_hz, rate)
    if 2 * low_pass.settle_samples >= len(time):
        raise NotIdentifiable(f"{time[-1] - time[0]:.3g} s are too short for a low-pass at {cutoff_hz:g} Hz")
    return low_pass


def into_sensor(rotation: Array, wrench: Array) -> Array:
    """(T, 6) in {S}. rotation: (T, 3, 3) R_BS; wrench: (T, 6) in {B}'s axes."""
    both = np.einsum("tji,taj->tai", rotation, wrench.reshape(-1, 2, 3))
    return np.asarray(both.reshape(-1, 6))
