"""The recipe: postures, motion, what is missing, then what is left of wrenches where nothing, or something, touches."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.criteria import USUAL, Criteria
from exogauge.errors import BadStudy, Fault
from exogauge.findings.verdict import Caveat
from exogauge.payload.calibration import Calibration, Declared, calibrate, uncalibrated
from exogauge.payload.contact import Compensation
from exogauge.payload.contract import Role
from exogauge.payload.dynamics import batch, reading_of_mu, static_prior
from exogauge.payload.imu import ImuFrame, find_axes, find_lag
from exogauge.payload.intake import Payload, Recording
from exogauge.payload.limits import saturation
from exogauge.payload.missing.effect import Frame
from exogauge.payload.missing.search import Missing, find_missing, unjudged
from exogauge.payload.missing.stretch import Stretch, moving_stretch, still_stretch
from exogauge.payload.missing.words import cause_of_residual
from exogauge.payload.prepare import Moved, declared_of, holds_of, low_pass_of, moving, rows_of, std_of
from exogauge.payload.remainder import Remainder, remainder
from exogauge.payload.stages import (
    Excitation,
    Postures,
    excitation_stage,
    naming,
    postures_stage,
    prior_of,
    stated_sign,
)
from exogauge.payload.statics import Holds, static_stage
from exogauge.payload.touches import Touch, found_touches, zeroed
from exogauge.progress import Doing, Stage, Staged, nobody

Array = NDArray[np.float64]

MOVED: tuple[Role, ...] = ("excitation", "test", "contact")
NO_DOUBT = np.zeros((18, 18))


@final
@dataclass(frozen=True)
class Stages:
    """What both stages say, of wrenches as read or with what was named missing taken out of them. compensation: in what
    the sensor reads, so that what its calibration leaves in doubt is none there. exact: the same, were that exact."""

    postures: Postures | None
    excitation: Excitation | None
    gravity: Array
    compensation: Compensation
    warnings: tuple[str, ...]
    calibration: Calibration | None = None
    exact: Stages | None = None

    @property
    def body(self) -> Array:
        """(10,) [m, m c, I]; without motion the inertia is 0."""
        out = np.zeros(10)
        if self.excitation is not None:
            return self.excitation.chosen.value[:10]
        if self.postures is not None:
            out[:4] = self.postures.chosen.moments[0][:4]
        return out

    @property
    def scale(self) -> tuple[float, float]:
        """By which gains and crosstalk are worse than declared."""
        return (1.0, 1.0) if self.calibration is None else self.calibration.scale


@final
@dataclass(frozen=True)
class Evaluation:
    """stages: what is told. rigid: the same of a rigid body behind an ideal sensor alone, where `stages` holds what was
    named missing. level: what is found where the base is taken to be level; None without postures or excitation.
    criteria: by which numbers it was decided."""

    payload: Payload
    sign: int
    stages: Stages
    rigid: Stages | None
    level: Compensation | None
    tests: Mapping[str, Mapping[str, Remainder]]
    touches: Mapping[str, tuple[Touch, ...]]
    thresholds: Mapping[str, float]
    imu: ImuFrame | None
    missing: Missing
    warnings: tuple[str, ...]
    criteria: Criteria


@final
@dataclass(frozen=True)
class _Logs:
    """What was read, on one clock each; acceleration: (K, 3) of the IMU in the postures."""

    holds: Holds | None
    acceleration: Array | None
    excitation: Sequence[Moved]
    test: Sequence[Moved]
    contact: Sequence[Moved]

    def each(self, read: Callable[[Array], Array]) -> _Logs:
        """read: of (T, 6) wrenches what is put in their place."""
        moved = (
            [replace(m, wrench=read(m.wrench)) for m in logs] for logs in (self.excitation, self.test, self.contact)
        )
        holds = self.holds and replace(self.holds, wrench=read(self.holds.wrench))
        return _Logs(holds, self.acceleration, *moved)

    def without(self, wrenches: Sequence[Array]) -> _Logs:
        """wrenches: (T, 6) of what is taken out, of the postures first, if there are any."""
        parts = list(wrenches)
        holds = self.holds and replace(self.holds, wrench=self.holds.wrench - parts.pop(0))
        excitation, test, contact = (
            [replace(each, wrench=each.wrench - parts.pop(0)) for each in logs]
            for logs in (self.excitation, self.test, self.contact)
        )
        return _Logs(holds, self.acceleration, excitation, test, contact)


def evaluate(payload: Payload, progress: Staged = nobody, criteria: Criteria = USUAL) -> Evaluation:
    """Raises BadInput, NotIdentifiable."""
    if not payload.of("postures") and not payload.of("excitation"):
        advice = "Give a log the role `postures` (the arm stops here and there) or `excitation`."
        raise BadStudy(Fault("no log identifies the payload", "no_role", advice, payload.name, None, "logs"))
    holds, acceleration = None, None
    if payload.of("postures"):
        progress(0.0, Stage.POSTURES, Doing.FINDING_POSTURES)
        holds, acceleration = holds_of(payload, criteria.payload_static)
        progress(0.05, Stage.POSTURES, Doing.IDENTIFYING_STILL)
    postures, said = _still(payload, holds, acceleration, criteria)
    if postures is not None:
        holds, acceleration = postures.holds, postures.acceleration  # without those that were touched
    sign = postures.chosen.sign if postures else stated_sign(payload)
    gravity = postures.chosen.gravity if postures else np.array(payload.file.gravity)
    imu = None
    if payload.file.imu is not None and postures:
        progress(0.08, Stage.POSTURES, Doing.PLACING_IMU)
        imu = _imu(payload, postures, gravity, criteria)
    excitation, test, contact = (_moved(payload, role, gravity, imu, progress, criteria) for role in MOVED)
    logs = _Logs(holds, acceleration, excitation, test, contact)
    if excitation:
        progress(0.3, Stage.EXCITATION, Doing.IDENTIFYING_MOVED)
    stages, rigid = _stages(payload, logs, sign, postures, said, criteria), None
    if excitation:
        progress(0.5, Stage.MISSING, Doing.LOOKING_FOR_MISSING)
    missing = _missing(payload, stages, logs, sign, criteria)
    named = any(each.effect in ("gain", "crosstalk") for each in missing.found)
    clean, sensor = logs, declared_of(payload.file, criteria, contradicted=named)
    blamed = missing.of_sensor or missing.decision.verdict == "unexplained"
    as_sensor = None
    if blamed and not sensor.exact:
        progress(0.7, Stage.MISSING, Doing.IDENTIFYING_AGAIN)
        as_sensor = _of_sensor(payload, logs, stages, sensor, sign, missing, criteria)
    if as_sensor is not None:
        (stages, clean, missing), rigid = as_sensor, stages
    else:
        doubt, scale = missing.late_doubt, None
        if missing.in_the_model:
            rigid, _ = _calibrated(payload, logs, stages, sensor, sign, criteria, missing.late_doubt, take=False)
            clean, doubt, scale = logs.without(missing.courses), missing.doubt, rigid.scale
        if missing.in_the_model and missing.of_body:
            progress(0.7, Stage.MISSING, Doing.IDENTIFYING_AGAIN)
            again = _still(payload, clean.holds, clean.acceleration, criteria)
            stages = _stages(payload, clean, sign, *again, criteria, doubt)
        elif missing.late is not None:
            stages = _stages(payload, logs, sign, postures, said, criteria, doubt)
        holds_good = missing.in_the_model or missing.decision.verdict in ("none", "undecided")
        stages, clean = _calibrated(
            payload, clean, stages, sensor, sign, criteria, doubt, take=holds_good, scale=scale
        )  # fmt: skip
    if contact:
        progress(0.8, Stage.CONTACT, Doing.LOOKING_FOR_TOUCHES)
    moving_zero = any(each.effect.startswith("zero") for each in (*missing.found, *missing.suspected))
    contact, of_contact = zeroed(payload, stages.compensation, clean.contact, moving_zero, criteria)
    touches, thresholds = found_touches(payload, stages.compensation, contact, sign, criteria)
    touched = postures.touched if postures else ()
    warnings = [*saturation(payload, criteria), *told_clocks(payload), *_told_noise(payload, logs), *touched, *said,
                *of_contact, *stages.warnings, *_doubts(stages, rigid, missing, criteria)]  # fmt: skip
    if test:
        progress(0.9, Stage.CONTACT, Doing.COMPARING_METHODS)
    level = _level(payload, (rigid or stages).postures, logs.excitation, criteria)
    tests = _tests(payload, stages, rigid, level, logs, clean, criteria)
    return Evaluation(
        payload, sign, stages, rigid, level, tests, touches, thresholds, imu, missing,
        tuple(dict.fromkeys(warnings)), criteria,
    )  # fmt: skip


def told_clocks(payload: Payload) -> list[str]:
    """A sentence for each log whose stamps were replaced."""
    return [
        f"{each.pose.file}, column '{payload.file.time.column}': stamps jitter by {1e3 * each.evened:.2g} ms though "
        "samples were taken evenly, as the pose tells: replaced by the even clock beneath them."
        for each in payload.recordings
        if each.evened > 0.0
    ]


def _told_noise(payload: Payload, logs: _Logs) -> list[str]:
    """A sentence for each log whose pose shows more noise than is stated."""
    stated = payload.file.pose.noise_rad
    return [
        f"{recording.pose.file}: a channel of the pose scatters {each.motion.noisier:.2g} times as much as stated "
        f"(`pose.noise_rad` {stated:g}{'' if recording.position is None else ', `noise_m`'}): taken as found. A clock "
        "that is not that of the samples does the same."
        for role, moved in zip(MOVED, (logs.excitation, logs.test, logs.contact), strict=True)
        for recording, each in zip(payload.of(role), moved, strict=True)
        if each.motion.noisier > 1.0
    ]


def _moved(
    payload: Payload, role: Role, gravity: Array, imu: ImuFrame | None, progress: Staged, criteria: Criteria
) -> list[Moved]:
    out = list[Moved]()
    for recording in payload.of(role):
        done = MOVED.index(role) + len(out) / len(payload.of(role))
        progress(0.1 + 0.2 * done / len(MOVED), Stage.KINEMATICS, Doing.SMOOTHING_MOTION, recording.name)
        out.append(moving(payload, recording, gravity, imu, criteria.payload_dynamic))
    return out


def _still(
    payload: Payload, holds: Holds | None, acceleration: Array | None, criteria: Criteria
) -> tuple[Postures | None, list[str]]:
    warnings: list[str] = []
    if holds is None:
        return None, warnings
    with naming(payload.of("postures")):
        return postures_stage(payload, holds, acceleration, warnings, criteria), warnings


def _stages(
    payload: Payload, logs: _Logs, sign: int, postures: Postures | None, said: Sequence[str], criteria: Criteria,
    doubt: Array = NO_DOUBT,
) -> Stages:  # fmt: skip
    warnings = list(said)
    gravity = postures.chosen.gravity if postures else np.array(payload.file.gravity)
    excitation = None
    if logs.excitation:
        excitation = excitation_stage(payload, postures, logs.excitation, gravity, sign, warnings, criteria)
        chosen = excitation.chosen.doubted(doubt[:16, :16], criteria.payload_dynamic)
        excitation = replace(excitation, chosen=chosen)
    if postures:
        postures = replace(postures, chosen=postures.chosen.doubted(doubt))
    compensation = _compensation(payload, postures, excitation, gravity, sign, criteria)
    return Stages(postures, excitation, gravity, compensation, tuple(warnings))


def _calibrated(
    payload: Payload, logs: _Logs, stages: Stages, sensor: Declared, sign: int, criteria: Criteria, doubt: Array, *,
    take: bool, scale: tuple[float, float] | None = None,
) -> tuple[Stages, _Logs]:  # fmt: skip
    """With the doubt that the sensor's calibration adds; what is likeliest of it taken out of all logs where `take`.
    doubt: beside that. scale: by which the sensor is worse than declared, where that is known by now."""
    if sensor.exact:
        return replace(stages, calibration=uncalibrated(sensor), exact=stages), logs
    still, moving = list[Stretch](), list[Stretch]()
    if stages.postures is not None:
        still = [still_stretch(stages.postures.holds, stages.gravity, sign, criteria.payload)]
    if stages.excitation is not None:
        moving = [
            each.without(stages.excitation.left_out)
            for each in _stretches(payload, "excitation", logs.excitation, stages, sign, criteria)
        ]
    inclined = stages.postures is not None and stages.postures.chosen.inclined
    frame = Frame(stages.gravity, sign, stages.body)
    found = calibrate(sensor, [*still, *moving], frame, inclined, take=take, scale=scale)
    if found.taken.any():
        logs = logs.each(found.corrected)
        again = _still(payload, logs.holds, logs.acceleration, criteria)
        stages = _stages(payload, logs, sign, *again, criteria, doubt)
    postures, excitation, body = stages.postures, stages.excitation, stages.body
    if postures is not None:
        postures = replace(postures, chosen=postures.chosen.doubted(found.doubt(body, found.still)))
    if excitation is not None:
        more = found.doubt(body, (*found.still, *found.moving))[:16, :16]
        chosen = excitation.chosen.doubted(more, criteria.payload_dynamic)
        mass, std = excitation.mass_alone
        alone = (mass, float(np.hypot(std, np.sqrt(more[0, 0]))))
        excitation = replace(excitation, chosen=chosen, mass_alone=alone)
    return replace(stages, postures=postures, excitation=excitation, calibration=found, exact=stages), logs


def _of_sensor(
    payload: Payload, logs: _Logs, stages: Stages, sensor: Declared, sign: int, missing: Missing, criteria: Criteria
) -> tuple[Stages, _Logs, Missing] | None:
    """With gains and crosstalk of all axes at once in place of what was named, where they leave nothing above the
    noise; None where they do not."""
    found, clean = _calibrated(payload, logs, stages, sensor, sign, criteria, missing.late_doubt, take=True)
    assert found.calibration is not None
    assert found.exact is not None
    left = dict[str, Array]()
    roles: tuple[Role, Role] = ("excitation", "test")
    for role, moved in zip(roles, (clean.excitation, clean.test), strict=True):
        for each in _stretches(payload, role, moved, found.exact, sign, criteria):
            external = found.compensation.external(each.motion, each.wrench)
            left[each.name] = np.sqrt(np.mean((external / each.floor)[each.use] ** 2, axis=0))
    above = any(bool(np.any(ratios > criteria.judging.above)) for ratios in left.values())
    if above or found.calibration.evidence < criteria.payload.worth:
        return None
    return found, clean, missing.with_sensor(found.calibration, left, criteria)


def _doubts(stages: Stages, rigid: Stages | None, missing: Missing, criteria: Criteria) -> list[str]:
    """What the motion's residual says, and where something touched."""
    excitation, out = stages.excitation, list[str]()
    if excitation is None:
        return out
    if excitation.noise_known:
        mu, mu_std, cause = excitation.chosen.mu, excitation.chosen.mu_std, cause_of_residual(missing)
        reading = reading_of_mu(mu, mu_std, cause, criteria.payload_dynamic)
        out += [reading] if reading else []
    if missing.late is not None:
        late, std = (1e3 * each for each in missing.late)
        way = "late" if late > 0.0 else "early"
        out.append(
            f"The wrench seems {abs(late):.2g} ± {std:.1g} ms {way} against the pose: too little to be named; the "
            "doubt of all numbers holds it."
        )
    if excitation.left_out and (rigid is not None or not missing.found):
        spans = ", ".join(f"{a:.2f} to {b:.2f} s" for a, b in excitation.left_out[:5])
        out.append(f"Something touched the payload in the excitation; left out: {spans}.")
    return out


def _missing(payload: Payload, stages: Stages, logs: _Logs, sign: int, criteria: Criteria) -> Missing:
    """What was left out as a touch is looked at too: it may be what is missing. Undecided where the noise is not known:
    then nothing says how much may be left."""
    postures, excitation = stages.postures, stages.excitation
    if excitation is None:
        return unjudged(Caveat("no_motion"))
    if not excitation.noise_known:
        return unjudged(Caveat("noise_unknown"))
    body, gravity = excitation.chosen.value[:10], stages.gravity

    def stretches(role: Role, moved: Sequence[Moved]) -> list[Stretch]:
        return _stretches(payload, role, moved, stages, sign, criteria)

    fitted, held_out = stretches("excitation", logs.excitation), stretches("test", logs.test)
    others = stretches("contact", logs.contact)
    still = [still_stretch(postures.holds, gravity, sign, criteria.payload)] if postures else []
    frame = Frame(gravity, sign, body)
    inclined = postures is not None and postures.chosen.inclined
    whole = find_missing([*still, *fitted], held_out, others, frame, inclined, criteria)
    if whole.found or not excitation.left_out:
        return whole
    untouched = [each.without(excitation.left_out) for each in fitted]
    return find_missing([*still, *untouched], held_out, others, frame, inclined, criteria)


def _stretches(
    payload: Payload, role: Role, moved: Sequence[Moved], stages: Stages, sign: int, criteria: Criteria
) -> list[Stretch]:
    assert stages.excitation is not None
    body, at_rest = (
        stages.excitation.chosen.value[:10],
        None if stages.postures is None else stages.postures.holds.noise,
    )
    return [
        moving_stretch(
            recording.name, each.motion, each.wrench, stages.gravity, sign, body, std_of(payload), criteria.payload,
            at_rest,
        )
        for recording, each in zip(payload.of(role), moved, strict=True)
    ]  # fmt: skip


def _tests(
    payload: Payload,
    stages: Stages,
    rigid: Stages | None,
    level: Compensation | None,
    logs: _Logs,
    clean: _Logs,
    criteria: Criteria,
) -> dict[str, dict[str, Remainder]]:
    """By log and way. `all`: everything taken out; `rigid`: but what was named missing; `level`, `static`: the first
    two methods of [Payload] V, of wrenches as read."""
    out: dict[str, dict[str, Remainder]] = {}
    plain = rigid or stages
    for recording, read, test in zip(payload.of("test"), logs.test, clean.test, strict=True):
        ways = {"all": stages.compensation.external(test.motion, test.wrench)}
        if rigid is not None:
            ways["rigid"] = rigid.compensation.external(read.motion, read.wrench)
        if level is not None and plain.postures is not None:
            ways["level"] = level.external(read.motion, read.wrench)
            ways["static"] = read.wrench - plain.postures.by_method["tls"].predict(read.motion.rotation)
        inner, passed = _slow(payload, test.motion.time)
        out[recording.name] = {
            name: remainder(passed(left)[inner], test.motion.rows(inner), stages.gravity, criteria.payload_dynamic)
            for name, left in ways.items()
        }
    return out


def _slow(payload: Payload, time: Array) -> tuple[slice, Callable[[Array], Array]]:
    """What keeps of (T, 6) what lies below the cut-off, if there is one, and the samples then to be trusted."""
    low_pass = low_pass_of(payload.file.settings.cutoff_hz, time)
    if low_pass is None:
        return slice(None), lambda values: values
    return slice(low_pass.settle_samples, len(time) - low_pass.settle_samples), low_pass.apply


def _level(
    payload: Payload, postures: Postures | None, moved: Sequence[Moved], criteria: Criteria
) -> Compensation | None:
    """What is found where the base is taken to be level: by TLS, as the second method of [Payload] V, where noise is
    known. None without postures or excitation."""
    if postures is None or not moved:
        return None
    gravity, sign = np.array(payload.file.gravity), postures.chosen.sign
    chosen = static_stage(postures.holds, gravity, sign, inclined=False, criteria=criteria.payload_static)
    other = replace(postures, chosen=chosen)
    known = payload.file.settings.cutoff_hz is None and all(each.noise_known for each in moved)
    rows = rows_of(payload, moved, gravity, sign)
    found = batch(rows, prior_of(payload, other, criteria), "tls" if known else "ls")
    return Compensation(found.value, np.zeros((16, 16)), gravity, sign, rows.std)


def _compensation(
    payload: Payload,
    postures: Postures | None,
    excitation: Excitation | None,
    gravity: Array,
    sign: int,
    criteria: Criteria,
) -> Compensation:
    if excitation is not None:
        x, covariance = excitation.chosen.value, excitation.chosen.covariance
    else:
        assert postures is not None
        prior = static_prior(postures.chosen, criteria=criteria.payload_dynamic)
        known = np.array([0, 1, 2, 3, *range(10, 16)])
        x, covariance = prior.value, np.zeros((16, 16))
        covariance[np.ix_(known, known)] = prior.covariance[np.ix_(known, known)]
    return Compensation(x, covariance, gravity, sign, std_of(payload))


def _imu(payload: Payload, postures: Postures, gravity: Array, criteria: Criteria) -> ImuFrame | None:
    if postures.acceleration is None:
        return None
    frame = find_axes(postures.acceleration, postures.holds.rotation, gravity)
    most, imu = criteria.payload_doctor.other_gain, payload.file.imu
    gain = 1.0 / float(np.median(frame.gain))
    if imu is not None and not 1.0 / most < gain < most:
        detail = f"the IMU reads {gain:.4g} times gravity in the postures"
        files = payload.of("postures")[0].acceleration
        advice = "Check `imu.unit`: m/s^2, g, mg."
        file = "" if files is None else files.file
        raise BadStudy(Fault(detail, "imu_unit", advice, file, None, imu.acceleration[0], f"{gain:.4g}"))
    if payload.file.imu is not None and payload.file.imu.delay_s is not None:
        return replace(frame, lag_s=0.0)  # taken off when the file was read
    carrying = [
        each for each in (*payload.of("excitation"), *payload.of("test"))
        if each.acceleration is not None and each.rotation is not None and each.position is None
    ]  # fmt: skip
    sign = postures.chosen.sign

    def rows(lag: float) -> list[Array]:
        """Of the logs one by one: each has its own zero, and all share the stamps of one IMU."""
        moved = (
            moving(payload, recording, gravity, replace(frame, lag_s=lag), criteria.payload_dynamic)
            for recording in carrying
        )
        return [rows_of(payload, [each], gravity, sign).z for each in moved]

    if not carrying:
        return frame
    found = find_lag(frame, rows, criteria.payload_static)
    return replace(found, lag_std_s=float(np.hypot(found.lag_std_s, max(map(_clocks_std, carrying)))))


def _clocks_std(recording: Recording) -> float:
    """Std [s] of what stamps of several clocks leave open: each says when a sample was there, which was taken at any
    time in the period before. 0 with one clock."""
    streams = (recording.wrench, recording.pose, recording.acceleration)
    periods = {each.file: float(np.median(np.diff(each.time))) for each in streams if each is not None}
    return float(np.linalg.norm(list(periods.values()))) / np.sqrt(12.0) if len(periods) > 1 else 0.0
