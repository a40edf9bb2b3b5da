"""What was recorded, made ready for the stages: postures, motion on one clock, rows below a cut-off."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
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
from exogauge.logs.model import Log
from exogauge.logs.resampling import to_common_clock
from exogauge.payload.calibration import Declared
from exogauge.payload.contract import PayloadFile, Role, SensorUncertainty
from exogauge.payload.dynamics import Rows, dynamic_rows
from exogauge.payload.holds import find_holds
from exogauge.payload.imu import ImuFrame
from exogauge.payload.intake import Payload, Recording, Stream
from exogauge.payload.sensor_motion import SensorMotion, from_joints, from_pose, rotations, turning
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


def rounded_mean(step: float, noise: float) -> float:
    """Std of the error that rounding to steps leaves in the mean of many samples: all of it where the noise before it,
    of this std, is small against a step; none where it is as large as one.

    Of x = mean + noise, what rounding takes off has the Fourier series Σ step / (π k) sin(2π k x / step), up to sign;
    noise of std σ leaves exp(-2 (π k σ / step)²) of each.
    """
    if step == 0.0:
        return 0.0
    k = np.arange(1, 51)
    waves = step / (np.pi * k) * np.exp(-2.0 * (np.pi * k * noise / step) ** 2)
    return float(np.sqrt(np.sum(waves**2) / 2.0))


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
    pose, settings = payload.file.pose, payload.file.settings
    streams: dict[str, Stream] = {"w": recording.wrench, "p": recording.pose}
    if recording.position is not None:
        streams["x"] = recording.position
    elif recording.acceleration is not None and imu is not None:
        late = replace(recording.acceleration, time=recording.acceleration.time - imu.lag_s)
        streams["a"] = replace(late, values=imu.in_sensor(late.values))
    elif payload.tree is None:
        detail = "without position, joint angles or an IMU nothing says how the sensor accelerates"
        advice = "Log the position of the sensor, or an IMU and postures that tell how it sits."
        raise BadStudy(Fault(detail, "no_acceleration", advice, recording.pose.file))
    first = recording.wrench.time
    same = all(np.array_equal(each.time, first) for each in streams.values())
    at = None if same or "a" in streams else first
    if not same and at is None:
        streams = _one_clock(streams, recording.name)
    time, values = streams["p"].time, streams["p"].values
    if payload.tree is not None:
        frame = payload.file.sensor.frame or ""
        motion = from_joints(
            payload.tree,
            frame,
            time,
            values,
            pose.noise_rad,
            gravity,
            density=settings.jerk_density,
            criteria=criteria,
            at=at,
        )
    elif "x" in streams:
        motion = from_pose(
            time, values.reshape(-1, 3, 3), streams["x"].values, pose.noise_rad, pose.noise_m, gravity,
            density=settings.jerk_density, criteria=criteria, at=at, position_time=streams["x"].time,
        )  # fmt: skip
    else:
        R, alpha, omega = turning(time, values.reshape(-1, 3, 3), pose.noise_rad, criteria)
        a = streams["a"].values + np.einsum("tji,j->ti", R, gravity)
        motion = SensorMotion(time, R, a, alpha, omega, np.zeros((len(time), 9, 1)))
    wrench = streams["w"].values
    if at is not None:
        wrench = wrench[np.isin(at, motion.time)]
    if payload.file.sensor.axes == "base":
        wrench = into_sensor(motion.rotation, wrench)
    if not len(motion.time):
        advice = "Record longer, or check `time.unit` and `span`."
        detail = "pose and wrench have too little time in common"
        raise BadStudy(Fault(detail, "clocks_apart", advice, recording.pose.file))
    inner = slice(motion.edge, len(motion.time) - motion.edge)
    return Moved(motion.inner(), wrench[inner], "a" not in streams)


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
        parts = [
            Rows(part.z[k], part.noise[k], std, sign, None if part.tipped is None else part.tipped[k])
            for part, k in zip(parts, keep, strict=True)
        ]
    tipped = np.concatenate([p.tipped for p in parts if p.tipped is not None])
    return Rows(np.concatenate([p.z for p in parts]), np.concatenate([p.noise for p in parts]), std, sign, tipped)


def low_passed(rows: Rows, time: Array, cutoff_hz: float | None) -> Rows:
    """The same zero-phase filter on every column and on the wrench: it leaves the parameters where they are."""
    low_pass = low_pass_of(cutoff_hz, time)
    if low_pass is None:
        return rows
    edge = low_pass.settle_samples
    z = low_pass.apply(rows.z.reshape(len(time), -1)).reshape(rows.z.shape)[edge:-edge]
    noise = np.zeros((len(z), *rows.noise.shape[1:]))
    noise[:, -1, -1] = 6.0
    tipped = None if rows.tipped is None else low_pass.apply(rows.tipped.reshape(len(time), -1))[edge:-edge]
    return Rows(z, noise, rows.std, rows.sign, None if tipped is None else tipped.reshape(len(z), 3, 2))


def low_pass_of(cutoff_hz: float | None, time: Array) -> LowPass | None:
    """Raises NotIdentifiable where the log is too short for it."""
    rate = 1.0 / float(np.median(np.diff(time)))
    if cutoff_hz is None or cutoff_hz >= rate / 2:
        return None
    low_pass = LowPass(cutoff_hz, rate)
    if 2 * low_pass.settle_samples >= len(time):
        raise NotIdentifiable(f"{time[-1] - time[0]:.3g} s are too short for a low-pass at {cutoff_hz:g} Hz")
    return low_pass


def _one_clock(streams: Mapping[str, Stream], name: str) -> dict[str, Stream]:
    """On the clock of the slower of pose and acceleration, but not slower than the acceleration."""
    logs = [
        Log(name, s.time, {f"{key}.{k}": s.values[:, k] for k in range(s.values.shape[1])})
        for key, s in streams.items()
    ]
    paced = streams.get("a", streams["p"])
    rate = (len(paced.time) - 1) / float(paced.time[-1] - paced.time[0])
    log = to_common_clock(logs, rate, name)
    return {
        key: Stream(log.time, np.column_stack([log.channels[f"{key}.{k}"] for k in range(s.values.shape[1])]), s.file)
        for key, s in streams.items()
    }


def into_sensor(rotation: Array, wrench: Array) -> Array:
    """(T, 6) in {S}. rotation: (T, 3, 3) R_BS; wrench: (T, 6) in {B}'s axes."""
    both = np.einsum("tji,taj->tai", rotation, wrench.reshape(-1, 2, 3))
    return np.asarray(both.reshape(-1, 6))
