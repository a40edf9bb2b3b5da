"""The recipe: postures, then motion, then what is left of wrenches where nothing, or something, touches the payload."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.criteria import Criteria
from exogauge.errors import BadStudy, Fault, NotIdentifiable
from exogauge.payload.contact import Compensation, second_zero
from exogauge.payload.dynamics import (
    DynamicSolution,
    Method,
    Prior,
    batch,
    dynamic_stage,
    reading_of_mu,
    recursive,
    require_excitation,
    static_prior,
)
from exogauge.payload.imu import ImuFrame, find_axes, find_lag
from exogauge.payload.intake import Payload
from exogauge.payload.missing.effect import Frame
from exogauge.payload.missing.search import Missing, find_missing
from exogauge.payload.missing.stretch import moving_stretch, still_stretch
from exogauge.payload.prepare import Moved, holds_of, low_pass_of, moving, rows_of, std_of
from exogauge.payload.sensor_motion import SensorMotion
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
    with one more posture. acceleration: (K, 3) the IMU's mean in each, if there is one."""

    holds: Holds
    level: LeftOut | None
    inclined: LeftOut | None
    chosen: StaticSolution
    by_method: Mapping[Method, StaticSolution]
    further: tuple[Array, Array]
    acceleration: Array | None


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
    missing: Missing | None
    warnings: tuple[str, ...]


def evaluate(payload: Payload, progress: Callable[[float, str], None] = lambda share, doing: None) -> Evaluation:
    """progress: share done and what is being done. Raises BadInput, NotIdentifiable."""
    progress(0.0, "postures")
    warnings: list[str] = []
    gravity, imu = np.array(payload.file.gravity), None
    postures = _postures(payload, warnings) if payload.of("postures") else None
    sign = postures.chosen.sign if postures else stated_sign(payload)
    if postures:
        gravity = postures.chosen.gravity
    if payload.file.imu is not None and postures:
        imu = _imu(payload, postures, gravity)
    excitation = None
    progress(0.1, "excitation")
    moved = [moving(payload, recording, gravity, imu) for recording in payload.of("excitation")]
    if moved:
        excitation = _excitation(payload, postures, moved, gravity, sign, warnings)
    elif postures is None:
        advice = "Give a log the role `postures` (the arm stops here and there) or `excitation`."
        raise BadStudy(Fault("no log identifies the payload", "no_role", advice, payload.name, None, "logs"))
    tests: dict[str, dict[str, Remainder]] = {}
    touches: dict[str, tuple[Touch, ...]] = {}
    thresholds: dict[str, float] = {}
    progress(0.7, "what is left")
    compensation = _compensation(payload, postures, excitation, gravity, sign)
    ignoring = _level(payload, postures, moved) if payload.of("test") else None
    tested = [moving(payload, recording, gravity, imu) for recording in payload.of("test")]
    for recording, test in zip(payload.of("test"), tested, strict=True):
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
        limit = compensation.force_threshold(touched.motion, rate * period / 3600.0)
        thresholds[recording.name] = float(limit.max())
    missing = _missing(payload, postures, excitation, moved, tested, gravity, sign) if excitation else None
    if excitation and excitation.left_out and not (missing and missing.found):
        spans = ", ".join(f"{a:.2f} to {b:.2f} s" for a, b in excitation.left_out[:5])
        warnings.append(f"Something touched the payload in the excitation; left out: {spans}.")
    return Evaluation(
        payload, sign, postures, excitation, tests, touches, thresholds, imu, missing, tuple(dict.fromkeys(warnings))
    )  # fmt: skip


def _missing(
    payload: Payload, postures: Postures | None, excitation: Excitation, moved: Sequence[Moved],
    tested: Sequence[Moved], gravity: Array, sign: int,
) -> Missing | None:  # fmt: skip
    """None where the noise is not known: then nothing says how much may be left. What was left out as a touch is looked
    at too: it may be what is missing. moved, tested: logs of these roles."""
    if not excitation.noise_known:
        return None
    std = std_of(payload)
    fitted, held_out = (
        [
            moving_stretch(recording.name, each.motion, each.wrench, gravity, sign, excitation.chosen.value[:10], std)
            for recording, each in zip(recordings, motions, strict=True)
        ]
        for recordings, motions in ((payload.of("excitation"), moved), (payload.of("test"), tested))
    )
    still = [still_stretch(postures.holds, gravity, sign)] if postures else []
    frame = Frame(gravity, sign, excitation.chosen.value[:10])
    inclined = postures is not None and postures.chosen.inclined
    whole = find_missing([*still, *fitted], held_out, frame, inclined, Criteria())
    if whole.found or not excitation.left_out:
        return whole
    untouched = [each.without(excitation.left_out) for each in fitted]
    return find_missing([*still, *untouched], held_out, frame, inclined, Criteria())


def _slow(payload: Payload, time: Array) -> tuple[slice, Callable[[Array], Array]]:
    """What keeps of (T, 6) what lies below the cut-off, if there is one, and the samples then to be trusted."""
    low_pass = low_pass_of(payload.file.settings.cutoff_hz, time)
    if low_pass is None:
        return slice(None), lambda values: values
    return slice(low_pass.settle_samples, len(time) - low_pass.settle_samples), low_pass.apply


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
    holds, acceleration = holds_of(payload)
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
    return Postures(holds, level, tilted, chosen, by_method, further_posture(holds, chosen), acceleration)


def _excitation(
    payload: Payload, postures: Postures | None, moved: Sequence[Moved], gravity: Array, sign: int, warnings: list[str]
) -> Excitation:
    settings, prior = payload.file.settings, prior_of(payload, postures)
    known = all(each.noise_known for each in moved) and settings.cutoff_hz is None
    method: Method = settings.method if known else "ls"
    if settings.method != method:
        warnings.append(
            "Several clocks, an IMU or a low-pass: the noise of the regressor is not known, so LS decides and μ is not "
            "read."
        )

    rows = rows_of(payload, moved, gravity, sign)
    solution = dynamic_stage(rows, prior, method)
    pushed: list[tuple[float, float]] = []
    if settings.cutoff_hz is None and known:
        keep, pushed = _without_contact(payload, moved, solution, gravity, sign)
        if pushed:
            rows = rows_of(payload, moved, gravity, sign, keep)
            solution = dynamic_stage(rows, prior, method)
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
    known = payload.file.settings.cutoff_hz is None and all(each.noise_known for each in moved)
    rows = rows_of(payload, moved, gravity, sign)
    found = batch(rows, prior_of(payload, other), "tls" if known else "ls")
    return Compensation(found.value, np.zeros((16, 16)), gravity, sign, rows.std)


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
    if postures.acceleration is None:
        return None
    frame = find_axes(postures.acceleration, postures.holds.rotation, gravity)
    if payload.file.imu is not None and payload.file.imu.delay_s is not None:
        return replace(frame, lag_s=0.0)  # taken off when the file was read
    carrying = [
        each for each in (*payload.of("excitation"), *payload.of("test"))
        if each.acceleration is not None and each.rotation is not None and each.position is None
    ]  # fmt: skip
    sign = postures.chosen.sign

    def rows(lag: float) -> list[Array]:
        """Of the logs one by one: each has its own zero, and all share the stamps of one IMU."""
        moved = (moving(payload, recording, gravity, replace(frame, lag_s=lag)) for recording in carrying)
        return [rows_of(payload, [each], gravity, sign).z for each in moved]

    return find_lag(frame, rows) if carrying else frame


def _sign(sees: str) -> int:
    """s of [Payload]: +1 where the sensor reads what it does to the payload; `role: cut` counts the other way round."""
    return -int(SIGN[sees])


def stated_sign(payload: Payload) -> int:
    """s of [Payload], where no posture tells it."""
    if payload.file.sensor.sees is None:
        advice = "Say payload_on_sensor or sensor_on_payload, or hand in postures, which tell it."
        raise BadStudy(Fault("without postures the sign is not known", "no_sign", advice, payload.name, None, "sensor"))
    return _sign(payload.file.sensor.sees)
