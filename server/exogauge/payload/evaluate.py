"""The recipe: postures, then motion, then what is left of wrenches where nothing, or something, touches the payload."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.errors import BadStudy, Fault, NotIdentifiable
from exogauge.logs.filtering import LowPass
from exogauge.logs.model import Log
from exogauge.logs.resampling import to_common_clock
from exogauge.payload.contact import Compensation, second_zero
from exogauge.payload.dynamics import (
    DynamicSolution,
    Method,
    Prior,
    Rows,
    batch,
    dynamic_rows,
    dynamic_stage,
    reading_of_mu,
    recursive,
    require_excitation,
    static_prior,
)
from exogauge.payload.holds import find_holds
from exogauge.payload.imu import ImuFrame, find_axes, find_lag
from exogauge.payload.intake import Payload, Recording, Stream
from exogauge.payload.sensor_motion import SensorMotion, from_joints, from_pose, rotations, turning
from exogauge.payload.statics import (
    Holds,
    LeftOut,
    StaticSolution,
    further_posture,
    leave_one_out,
    misread_rotation,
    static_stage,
    told_sign,
)
from exogauge.studies.intake.robot_file import SIGN

Array = NDArray[np.float64]

METHODS: tuple[Method, ...] = ("ls", "tls", "gtls")
STEEP = np.radians(15.0)  # a base inclined more than that is a wrong pose, gravity or pair of axes
LONG = 3.0  # m from the sensor to a centre of mass: beyond, moments are in other units
PUSH_MARGIN_S = 0.2  # left out on either side of a contact
MOST_PUSHED = 0.3  # of the excitation: more is no contact but a model that does not hold
RELEASED = 1000.0  # N, N·m: std of a zero that is not that of the postures


@final
@dataclass(frozen=True)
class Postures:
    """holds; level, inclined: errors in left-out postures without and with U, V, None where one cannot be missed;
    chosen: the solution used; by_method: the same by LS, TLS, GTLS; further: gravity's direction in {S} and std (12,)
    with one more posture."""

    holds: Holds
    level: LeftOut | None
    inclined: LeftOut | None
    chosen: StaticSolution
    by_method: Mapping[Method, StaticSolution]
    further: tuple[Array, Array]


@final
@dataclass(frozen=True)
class Excitation:
    """by_method: solutions; chosen: the one used. recursion: what the recursion ends with, (16,); mass_alone: mass and
    its std from motion, without the postures' mass. noise_known: whether μ may be read. density: of each channel."""

    by_method: Mapping[Method, DynamicSolution]
    chosen: DynamicSolution
    recursion: Array
    mass_alone: tuple[float, float]
    noise_known: bool
    density: Array
    left_out: tuple[tuple[float, float], ...]


@final
@dataclass(frozen=True)
class Remainder:
    """What compensation leaves in a log without contact: at t = 0, mean, std of |f| and |τ|; rms and largest per axis;
    largest after the secondary zero, where it helps, and the share of time in which it does."""

    first: tuple[float, float]
    mean: tuple[float, float]
    std: tuple[float, float]
    rms: Array
    most: Array
    most_after_zero: Array
    zero_helps: float


@final
@dataclass(frozen=True)
class Touch:
    """A contact: span [s], largest force of the environment on the payload (3,) [N] in {S}."""

    start: float
    end: float
    force: Array


@final
@dataclass(frozen=True)
class Evaluation:
    payload: Payload
    sign: int
    postures: Postures | None
    excitation: Excitation | None
    tests: Mapping[str, Mapping[str, Remainder]]
    touches: Mapping[str, tuple[Touch, ...]]
    thresholds: Mapping[str, float]
    imu: ImuFrame | None
    warnings: tuple[str, ...]


@final
@dataclass(frozen=True)
class Moved:
    """A log on one clock. noise_known: every sample is as it was measured, so that its noise is the stated one."""

    motion: SensorMotion
    wrench: Array
    noise_known: bool


def evaluate(payload: Payload) -> Evaluation:
    """Raises BadInput, NotIdentifiable."""
    warnings: list[str] = []
    gravity, imu = np.array(payload.file.gravity), None
    postures = _postures(payload, warnings) if payload.of("postures") else None
    sign = postures.chosen.sign if postures else _stated_sign(payload)
    if postures:
        gravity = postures.chosen.gravity
    if payload.file.imu is not None and postures:
        imu = _imu(payload, postures, gravity)
    excitation = None
    moved = [moving(payload, recording, gravity, imu) for recording in payload.of("excitation")]
    if moved:
        excitation = _excitation(payload, postures, moved, gravity, sign, warnings)
    elif postures is None:
        advice = "Give a log the role `postures` (the arm stops here and there) or `excitation`."
        raise BadStudy(Fault("no log identifies the payload", "no_role", advice, payload.name, None, "logs"))
    tests: dict[str, dict[str, Remainder]] = {}
    touches: dict[str, tuple[Touch, ...]] = {}
    thresholds: dict[str, float] = {}
    compensation = _compensation(payload, postures, excitation, gravity, sign)
    ignoring = _level(payload, postures, moved) if payload.of("test") else None
    for recording in payload.of("test"):
        test = moving(payload, recording, gravity, imu)
        ways = {"all": compensation.external(test.motion, test.wrench)}
        if ignoring is not None and postures is not None:
            ways["level"] = ignoring.external(test.motion, test.wrench)
            ways["static"] = test.wrench - postures.by_method["tls"].predict(test.motion.rotation)
        inner, passed = _slow(payload, test.motion.time)
        tests[recording.name] = {
            name: remainder(passed(left)[inner], test.motion.rows(inner), gravity) for name, left in ways.items()
        }
    for recording in payload.of("contact"):
        touched = moving(payload, recording, gravity, imu)
        rate = payload.file.settings.false_alarms_per_hour
        external = compensation.external(touched.motion, touched.wrench)
        touches[recording.name] = tuple(
            _touch(span, touched.motion.time, -sign * external)
            for span in compensation.contacts(touched.motion, touched.wrench, rate)
        )
        period = float(np.median(np.diff(touched.motion.time)))
        limit, _ = compensation.force_threshold(touched.motion, rate * period / 3600.0)
        thresholds[recording.name] = float(limit.max())
    return Evaluation(
        payload, sign, postures, excitation, tests, touches, thresholds, imu, tuple(dict.fromkeys(warnings))
    )  # fmt: skip


def std_of(payload: Payload) -> Array:
    """(6,) [N, N·m] of one sample."""
    noise = payload.file.sensor.noise
    return np.repeat([noise.force_n, noise.moment_nm], 3)


def holds_of(payload: Payload) -> tuple[Holds, Array | None]:
    """Every posture of every log, and the IMU's mean in each, (K, 3), if there is one. Raises BadStudy."""
    rotation, wrench, acceleration, counts, spans = [], [], [], list[int](), list[tuple[float, float]]()
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
        for a, b in find_holds(pose.time, pose.values, payload.file.pose.noise_rad):
            inside, mean = F.cut(a, b), pose.cut(a, b).values.mean(axis=0)
            if len(inside.time) < 2:
                continue
            if payload.tree:
                rotation.append(rotations(payload.tree, payload.file.sensor.frame or "", mean[None])[0])
            else:
                U, _, Vt = np.linalg.svd(mean.reshape(3, 3))
                rotation.append(U @ Vt)
            wrench.append(inside.values.mean(axis=0))
            counts.append(len(inside.time))
            spans.append((a, b))
            if recording.acceleration:
                acceleration.append(recording.acceleration.cut(a, b).values.mean(axis=0))
    if len(wrench) < 3:
        advice = "Hold the arm still for a second in each of at least six postures that differ in gravity."
        files = payload.of("postures")[0].wrench.file
        detail = f"{len(wrench)} postures were found in which nothing moved; at least three are needed"
        raise BadStudy(Fault(detail, "too_few_postures", advice, files, value=str(len(wrench))))
    R_BS, F_S = np.array(rotation), np.array(wrench)
    if payload.file.sensor.axes == "base":
        F_S = _into_sensor(R_BS, F_S)
    std = std_of(payload) / np.sqrt(np.median(counts))
    holds = Holds(R_BS, F_S, std, payload.file.pose.noise_rad, np.array(spans))
    return holds, np.array(acceleration) if len(acceleration) == len(F_S) else None


def moving(payload: Payload, recording: Recording, gravity: Array, imu: ImuFrame | None) -> Moved:
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
    if not same:
        streams = _one_clock(streams, recording.name)
    time, values = streams["p"].time, streams["p"].values
    if payload.tree is not None:
        frame = payload.file.sensor.frame or ""
        motion = from_joints(payload.tree, frame, time, values, pose.noise_rad, gravity, density=settings.jerk_density)
    elif "x" in streams:
        motion = from_pose(
            time, values.reshape(-1, 3, 3), streams["x"].values, pose.noise_rad, pose.noise_m, gravity,
            density=settings.jerk_density,
        )  # fmt: skip
    else:
        R, alpha, omega = turning(time, values.reshape(-1, 3, 3), pose.noise_rad)
        a = streams["a"].values + np.einsum("tji,j->ti", R, gravity)
        motion = SensorMotion(time, R, a, alpha, omega, np.zeros((len(time), 9, 1)))
    wrench = streams["w"].values
    if payload.file.sensor.axes == "base":
        wrench = _into_sensor(motion.rotation, wrench)
    inner = slice(motion.edge, len(time) - motion.edge)
    return Moved(motion.inner(), wrench[inner], same and "a" not in streams)


def _slow(payload: Payload, time: Array) -> tuple[slice, Callable[[Array], Array]]:
    """What keeps of (T, 6) what lies below the cut-off, if there is one, and the samples then to be trusted."""
    low_pass = _low_pass(payload.file.settings.cutoff_hz, time)
    if low_pass is None:
        return slice(None), lambda values: values
    return slice(low_pass.settle_samples, len(time) - low_pass.settle_samples), low_pass.apply


def _low_pass(cutoff_hz: float | None, time: Array) -> LowPass | None:
    """Raises NotIdentifiable where the log is too short for it."""
    rate = 1.0 / float(np.median(np.diff(time)))
    if cutoff_hz is None or cutoff_hz >= rate / 2:
        return None
    low_pass = LowPass(cutoff_hz, rate)
    if 2 * low_pass.settle_samples >= len(time):
        raise NotIdentifiable(f"{time[-1] - time[0]:.3g} s are too short for a low-pass at {cutoff_hz:g} Hz")
    return low_pass


def low_passed(rows: Rows, time: Array, cutoff_hz: float | None) -> Rows:
    """The same zero-phase filter on every column and on the wrench: it leaves the parameters where they are."""
    low_pass = _low_pass(cutoff_hz, time)
    if low_pass is None:
        return rows
    edge = low_pass.settle_samples
    z = low_pass.apply(rows.z.reshape(len(time), -1)).reshape(rows.z.shape)[edge:-edge]
    noise = np.zeros((len(z), *rows.noise.shape[1:]))
    noise[:, -1, -1] = 6.0
    return Rows(z, noise, rows.std, rows.sign)


def remainder(left: Array, motion: SensorMotion, gravity: Array) -> Remainder:
    """left: (T, 6) of a log without contact, below the cut-off if there is one."""
    f, tau = np.linalg.norm(left[:, :3], axis=1), np.linalg.norm(left[:, 3:], axis=1)
    zeroed, helps = second_zero(motion, left, gravity)
    return Remainder(
        (float(f[0]), float(tau[0])), (float(f.mean()), float(tau.mean())), (float(f.std()), float(tau.std())),
        np.sqrt(np.mean(left**2, axis=0)), np.abs(left).max(axis=0),
        np.abs(zeroed[helps]).max(axis=0), float(helps.mean()),
    )  # fmt: skip


def _postures(payload: Payload, warnings: list[str]) -> Postures:
    holds, _ = holds_of(payload)
    gravity, settings = np.array(payload.file.gravity), payload.file.settings
    misread = misread_rotation(holds, gravity)
    if misread is not None:
        detail, advice = {
            "transposed": ("the postures fit the transpose of this pose", "Give R_base_sensor: its columns are the "
                           "sensor's axes in the base. Check the order of a quaternion too."),
            "world_axes": ("the postures fit wrenches in the base's axes", "Say `sensor.axes: base`."),
            "sensor_axes": ("the postures fit wrenches in the sensor's own axes", "Say `sensor.axes: sensor`."),
            "unexplained": ("no weight explains the forces of these postures", "Check that nothing touched the "
                            "payload, that it does not shift, and the order and axes of pose and wrench."),
        }[misread]  # fmt: skip
        raise BadStudy(Fault(detail, f"pose_{misread}", advice, payload.of("postures")[0].pose.file))
    sign = told_sign(holds, gravity)
    stated = payload.file.sensor.sees
    if stated is not None and _sign(stated) != sign:
        other = next(name for name in ("payload_on_sensor", "sensor_on_payload") if name != stated)
        detail = "the weight points the other way than `sensor.sees` and `gravity` say"
        advice = f"Say `sees: {other}`, or turn `gravity` round."
        raise BadStudy(Fault(detail, "sees_contradicted", advice, payload.name, None, "sensor.sees", stated))
    errors: list[LeftOut | None] = []
    for inclined in (False, True):
        try:
            errors.append(leave_one_out(holds, gravity, sign, inclined=inclined))
        except NotIdentifiable:
            errors.append(None)
    level, tilted = errors
    better = level is None or tilted is None or tilted.force < level.force
    fit = {"fit": True, "ignore": False, "auto": better and tilted is not None}[settings.inclination]
    by_method = {method: static_stage(holds, gravity, sign, inclined=fit, method=method) for method in METHODS}
    chosen = by_method["ls"]
    if float(np.abs(chosen.tilt).max()) > STEEP:
        degrees = np.degrees(chosen.tilt)
        warnings.append(
            f"The base comes out inclined by {degrees[0]:.3g}° and {degrees[1]:.3g}°: the pose, `gravity` or the "
            "sensor's axes are wrong, or the base really leans."
        )
    if float(np.linalg.norm(chosen.centre)) > LONG:
        warnings.append(
            f"The centre of mass comes out {np.linalg.norm(chosen.centre):.3g} m from the sensor: check "
            "`sensor.moment_unit`."
        )
    return Postures(holds, level, tilted, chosen, by_method, further_posture(holds, chosen))


def _excitation(
    payload: Payload, postures: Postures | None, moved: Sequence[Moved], gravity: Array, sign: int, warnings: list[str]
) -> Excitation:
    settings, std = payload.file.settings, std_of(payload)
    prior = prior_of(payload, postures)
    known = all(each.noise_known for each in moved) and settings.cutoff_hz is None
    method: Method = settings.method if known else "ls"
    if settings.method != method:
        warnings.append(
            "Several clocks, an IMU or a low-pass: the noise of the regressor is not known, so LS decides and μ is not "
            "read."
        )

    def rows_of(keep: Sequence[NDArray[np.bool_]]) -> Rows:
        parts = [
            low_passed(dynamic_rows(each.motion, each.wrench, gravity, sign, std), each.motion.time, settings.cutoff_hz)
            for each in moved
        ]
        if settings.cutoff_hz is None:
            parts = [Rows(part.z[k], part.noise[k], std, sign) for part, k in zip(parts, keep, strict=True)]
        return Rows(np.concatenate([p.z for p in parts]), np.concatenate([p.noise for p in parts]), std, sign)

    everything = [np.ones(len(each.wrench), dtype=bool) for each in moved]
    rows = rows_of(everything)
    solution = dynamic_stage(rows, prior, method)
    pushed: list[tuple[float, float]] = []
    if settings.cutoff_hz is None and known:
        keep, pushed = _without_contact(payload, moved, solution, gravity, sign)
        if pushed:
            rows = rows_of(keep)
            solution = dynamic_stage(rows, prior, method)
            spans = ", ".join(f"{a:.2f} to {b:.2f} s" for a, b in pushed[:5])
            warnings.append(f"Something touched the payload in the excitation; left out: {spans}.")
    require_excitation(solution)
    by_method = {method: solution}
    by_method |= {each: dynamic_stage(rows, prior, each) for each in METHODS if known and each != method}
    if known:
        reading = reading_of_mu(solution.mu, solution.mu_std)
        warnings += [reading] if reading else []
    free = prior.covariance.copy()
    free[0], free[:, 0] = 0.0, 0.0
    free[0, 0] = max(prior.value[0], 1.0) ** 2
    alone = dynamic_stage(rows, Prior(prior.value, free), method)
    track, _ = recursive(rows, prior, method)
    return Excitation(
        by_method, solution, track[-1], (float(alone.value[0]), float(alone.std[0])), known,
        np.concatenate([np.zeros(0) if m.motion.density is None else m.motion.density for m in moved]), tuple(pushed),
    )  # fmt: skip


def prior_of(payload: Payload, postures: Postures | None) -> Prior:
    """From the postures, with what the settings release: a zero that drifted since, moments that motion decides."""
    prior = static_prior(postures.chosen if postures else None)
    settings, covariance = payload.file.settings, prior.covariance.copy()
    released = []
    if settings.zero == "drifted":
        released += [(k, RELEASED) for k in range(10, 16)]
    if settings.moments == "from_motion":
        released += [(k, max(float(prior.value[0]), 1.0)) for k in range(1, 4)]
    for k, std in released:
        covariance[k], covariance[:, k] = 0.0, 0.0
        covariance[k, k] = std**2
    return Prior(prior.value, covariance)


def _without_contact(
    payload: Payload, moved: Sequence[Moved], solution: DynamicSolution, gravity: Array, sign: int
) -> tuple[list[NDArray[np.bool_]], list[tuple[float, float]]]:
    """Which samples nothing touched, and the contacts; all samples where so many stand out that the model is wrong."""
    compensation = Compensation(solution.value, solution.covariance, gravity, sign, std_of(payload))
    keep, found = [], list[tuple[float, float]]()
    for each in moved:
        touched = [
            (a - PUSH_MARGIN_S, b + PUSH_MARGIN_S)
            for a, b in compensation.contacts(each.motion, each.wrench, payload.file.settings.false_alarms_per_hour)
            if b - a > PUSH_MARGIN_S / 4
        ]
        time = each.motion.time
        free = ~np.any([(time >= a) & (time <= b) for a, b in touched], axis=0) if touched else np.ones(len(time), bool)
        keep.append(np.asarray(free, dtype=bool))
        found += touched
    if np.mean(np.concatenate(keep)) < 1.0 - MOST_PUSHED:
        return [np.ones(len(each.wrench), dtype=bool) for each in moved], []
    return keep, found


def _level(payload: Payload, postures: Postures | None, moved: Sequence[Moved]) -> Compensation | None:
    """What is found where the base is taken to be level: by TLS, as the second method of [Payload] V, where noise is
    known. None without postures or excitation."""
    if postures is None or not moved:
        return None
    gravity, sign = np.array(payload.file.gravity), postures.chosen.sign
    other = replace(postures, chosen=static_stage(postures.holds, gravity, sign, inclined=False))
    std = std_of(payload)
    cutoff = payload.file.settings.cutoff_hz
    parts = [
        low_passed(dynamic_rows(each.motion, each.wrench, gravity, sign, std), each.motion.time, cutoff)
        for each in moved
    ]
    known = cutoff is None and all(each.noise_known for each in moved)
    rows = Rows(np.concatenate([p.z for p in parts]), np.concatenate([p.noise for p in parts]), std, sign)
    found = batch(rows, prior_of(payload, other), "tls" if known else "ls")
    return Compensation(found.value, np.zeros((16, 16)), gravity, sign, std)


def _compensation(
    payload: Payload, postures: Postures | None, excitation: Excitation | None, gravity: Array, sign: int
) -> Compensation:
    if excitation is not None:
        x, covariance = excitation.chosen.value, excitation.chosen.covariance
    else:
        assert postures is not None
        prior = static_prior(postures.chosen)
        known = np.array([0, 1, 2, 3, *range(10, 16)])
        x, covariance = prior.value, np.zeros((16, 16))
        covariance[np.ix_(known, known)] = prior.covariance[np.ix_(known, known)]
    return Compensation(x, covariance, gravity, sign, std_of(payload))


def _touch(span: tuple[float, float], time: Array, on_payload: Array) -> Touch:
    inside = on_payload[(time >= span[0]) & (time <= span[1]), :3]
    return Touch(span[0], span[1], inside[int(np.argmax(np.linalg.norm(inside, axis=1)))])


def _imu(payload: Payload, postures: Postures, gravity: Array) -> ImuFrame | None:
    _, acceleration = holds_of(payload)
    if acceleration is None:
        return None
    frame = find_axes(acceleration, postures.holds.rotation, gravity)
    if payload.file.imu is not None and payload.file.imu.delay_s is not None:
        return replace(frame, lag_s=0.0)  # taken off when the file was read
    carrying = [
        each for each in (*payload.of("excitation"), *payload.of("test"))
        if each.acceleration is not None and each.rotation is not None and each.position is None
    ]  # fmt: skip
    std, sign, cutoff = std_of(payload), postures.chosen.sign, payload.file.settings.cutoff_hz

    def rows(lag: float) -> list[Array]:
        """Of the logs one by one: each has its own zero, and all share the stamps of one IMU."""
        made = []
        for recording in carrying:
            moved = moving(payload, recording, gravity, replace(frame, lag_s=lag))
            of_log = dynamic_rows(moved.motion, moved.wrench, gravity, sign, std)
            made.append(low_passed(of_log, moved.motion.time, cutoff).z)
        return made

    return find_lag(frame, rows) if carrying else frame


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


def _into_sensor(rotation: Array, wrench: Array) -> Array:
    both = np.einsum("tji,taj->tai", rotation, wrench.reshape(-1, 2, 3))
    return np.asarray(both.reshape(-1, 6))


def _sign(sees: str) -> int:
    """s of [Payload]: +1 where the sensor reads what it does to the payload; `role: cut` counts the other way round."""
    return -int(SIGN[sees])


def _stated_sign(payload: Payload) -> int:
    if payload.file.sensor.sees is None:
        advice = "Say payload_on_sensor or sensor_on_payload, or hand in postures, which tell it."
        raise BadStudy(Fault("without postures the sign is not known", "no_sign", advice, payload.name, None, "sensor"))
    return _sign(payload.file.sensor.sees)
