"""The recipe: postures, motion, what is missing, then what is left of wrenches where nothing, or something, touches;
and what is said of the data beside the numbers.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.criteria import USUAL, Criteria
from exogauge.errors import BadStudy, Fault
from exogauge.findings.verdict import Caveat
from exogauge.payload.both_stages import Logs, Stages, calibrated, in_place_of_named
from exogauge.payload.contact import Compensation, Touch, found_touches, zeroed
from exogauge.payload.contract import Role
from exogauge.payload.dynamics import reading_of_mu
from exogauge.payload.imu import ImuFrame
from exogauge.payload.intake import Payload
from exogauge.payload.limits import require_bearable, require_liftable, saturation
from exogauge.payload.missing.at_rest import judged_at_rest, said_at_rest
from exogauge.payload.missing.effect import Frame
from exogauge.payload.missing.search import Missing, find_missing, unjudged
from exogauge.payload.missing.words import cause_of_residual
from exogauge.payload.placed_imu import placed_imu
from exogauge.payload.prepare import Moved, declared_of, holds_of, moving, shown_over_taken, stated_of, std_of
from exogauge.payload.remainder import Remainder, left_by_method, taken_to_be_level
from exogauge.payload.stages import Postures, stated_sign
from exogauge.progress import Doing, Stage, Staged, nobody

Array = NDArray[np.float64]

MOVED: tuple[Role, ...] = ("excitation", "test", "contact")


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
class _Told:
    """stages: of `clean`, logs without what is missing or is the sensor's. rigid: as `Evaluation` has it."""

    stages: Stages
    rigid: Stages | None
    clean: Logs
    missing: Missing


def evaluate(payload: Payload, progress: Staged = nobody, criteria: Criteria = USUAL) -> Evaluation:
    """Raises BadInput, NotIdentifiable."""
    if not payload.of("postures") and not payload.of("excitation"):
        advice = "Give a log the role `postures` (the arm stops here and there) or `excitation`."
        raise BadStudy(Fault("no log identifies the payload", "no_role", advice, payload.name, None, "logs"))
    require_bearable(payload, criteria)
    logs, postures, said, imu = _read(payload, progress, criteria)
    if logs.excitation:
        progress(0.3, Stage.EXCITATION, Doing.IDENTIFYING_MOVED)
    stages = logs.stages(postures, said)
    if logs.excitation:
        progress(0.5, Stage.MISSING, Doing.LOOKING_FOR_MISSING)
    require_liftable(payload, float(stages.body[0]), criteria)
    told = _with_what_is_missing(logs, stages, _missing(logs, stages), progress)
    stages, rigid, missing = told.stages, told.rigid, told.missing
    if logs.contact:
        progress(0.8, Stage.CONTACT, Doing.LOOKING_FOR_TOUCHES)
    moving_zero = any(each.effect.startswith("zero") for each in (*missing.found, *missing.suspected))
    contact, of_contact = zeroed(payload, stages.compensation, told.clean.contact, moving_zero, criteria)
    touches, thresholds = found_touches(payload, stages.compensation, contact, logs.sign, criteria)
    if logs.test:
        progress(0.9, Stage.CONTACT, Doing.COMPARING_METHODS)
    level = taken_to_be_level(logs, rigid or stages)
    tests = left_by_method(stages, rigid, level, logs, told.clean)
    warnings = [*saturation(payload, criteria), *told_clocks(payload), *told_noise(logs),
                *(postures.touched if postures else ()), *said, *of_contact, *stages.warnings,
                *told_weight(payload, stages, criteria), *told_wrench_noise(logs, stages),
                *doubts(payload, stages, rigid, missing, criteria)]  # fmt: skip
    return Evaluation(
        payload, logs.sign, stages, rigid, level, tests, touches, thresholds, imu, missing,
        tuple(dict.fromkeys(warnings)), criteria,
    )  # fmt: skip


def _read(
    payload: Payload, progress: Staged, criteria: Criteria
) -> tuple[Logs, Postures | None, list[str], ImuFrame | None]:
    """Logs on one clock each, without postures that were touched; what the postures say, and how the IMU sits."""
    gravity = np.array(payload.file.gravity)
    if not payload.of("postures"):
        moved = (_moved(payload, role, gravity, None, progress, criteria) for role in MOVED)
        return Logs(payload, stated_sign(payload), criteria, None, None, *moved), None, [], None
    progress(0.0, Stage.POSTURES, Doing.FINDING_POSTURES)
    logs = Logs(payload, 0, criteria, *holds_of(payload, criteria.payload_static), (), (), ())
    progress(0.05, Stage.POSTURES, Doing.IDENTIFYING_STILL)
    postures, said = logs.still()
    assert postures is not None
    sign, gravity, imu = postures.chosen.sign, postures.chosen.gravity, None
    if payload.file.imu is not None:
        progress(0.08, Stage.POSTURES, Doing.PLACING_IMU)
        imu = placed_imu(payload, postures, gravity, criteria)
    moved = (_moved(payload, role, gravity, imu, progress, criteria) for role in MOVED)
    return Logs(payload, sign, criteria, postures.holds, postures.acceleration, *moved), postures, said, imu


def _moved(
    payload: Payload, role: Role, gravity: Array, imu: ImuFrame | None, progress: Staged, criteria: Criteria
) -> list[Moved]:
    out = list[Moved]()
    for recording in payload.of(role):
        done = MOVED.index(role) + len(out) / len(payload.of(role))
        progress(0.1 + 0.2 * done / len(MOVED), Stage.KINEMATICS, Doing.SMOOTHING_MOTION, recording.name)
        out.append(moving(payload, recording, gravity, imu, criteria.payload_dynamic))
    return out


def _missing(logs: Logs, stages: Stages) -> Missing:
    """What was left out as a touch is looked at too: it may be what is missing. Undecided where the noise is not known:
    then nothing says how much may be left."""
    postures, excitation, criteria = stages.postures, stages.excitation, logs.criteria
    if excitation is None:
        assert postures is not None
        return judged_at_rest(postures.holds, postures.chosen, criteria)
    if not excitation.noise_known:
        return unjudged(Caveat("noise_unknown"))
    still, fitted = logs.still_stretches(stages), logs.stretches("excitation", stages)
    held_out, others = logs.stretches("test", stages), logs.stretches("contact", stages)
    frame = Frame(stages.gravity, logs.sign, excitation.chosen.value[:10])
    inclined = postures is not None and postures.chosen.inclined
    whole = find_missing([*still, *fitted], held_out, others, frame, inclined, criteria)
    if whole.found or not excitation.left_out:
        return whole
    untouched = [each.without(excitation.left_out) for each in fitted]
    return find_missing([*still, *untouched], held_out, others, frame, inclined, criteria)


def _with_what_is_missing(logs: Logs, stages: Stages, missing: Missing, progress: Staged) -> _Told:
    """All with what was named missing, if it can be told so, and with what the sensor's calibration leaves in doubt."""
    named = any(each.effect in ("gain", "crosstalk") for each in missing.found)
    sensor = declared_of(logs.payload.file, logs.criteria, contradicted=named)
    unexplained = missing.decision.verdict == "unexplained" and stages.excitation is not None
    if (missing.of_sensor or unexplained) and not sensor.exact:
        progress(0.7, Stage.MISSING, Doing.IDENTIFYING_AGAIN)
        as_sensor = in_place_of_named(logs, stages, sensor, missing)
        if as_sensor is not None:
            found, clean, instead = as_sensor
            return _Told(found, stages, clean, instead)
    if not missing.in_the_model:
        holds_good = missing.decision.verdict in ("none", "undecided")
        if missing.slight_doubt.any():
            stages = logs.stages(stages.postures, stages.warnings, missing.slight_doubt)
        found, clean = calibrated(logs, stages, sensor, missing.slight_doubt, take=holds_good)
        return _Told(found, None, clean, missing)
    rigid, _ = calibrated(logs, stages, sensor, missing.slight_doubt, take=False)
    clean = logs.without(missing.courses)
    if missing.of_body:
        progress(0.7, Stage.MISSING, Doing.IDENTIFYING_AGAIN)
        stages = clean.stages(*clean.still(), missing.doubt)
    elif missing.slight_doubt.any():
        stages = logs.stages(stages.postures, stages.warnings, missing.doubt)
    scale = None if missing.turned else rigid.scale  # a turn looks like a poor sensor
    found, clean = calibrated(clean, stages, sensor, missing.doubt, take=True, scale=scale)
    return _Told(found, rigid, clean, missing)


def told_weight(payload: Payload, stages: Stages, criteria: Criteria) -> list[str]:
    """What a mass on a scale contradicts, which never counts in the fit: a gain that all axes share, which no log
    shows, is a mass to them."""
    weighed = payload.file.ground_truth.mass_kg
    if weighed is None:
        return []
    if stages.excitation is not None:
        mass, std = float(stages.excitation.chosen.value[0]), float(stages.excitation.chosen.std[0])
    else:
        assert stages.postures is not None
        mass, std = stages.postures.chosen.mass, float(stages.postures.chosen.std[0])
    more, share = mass / weighed - 1.0, abs(mass / weighed - 1.0)
    if share > criteria.payload.other_mass:
        return [
            f"The mass comes out {mass / weighed:.3g} times the weighed one: check `sensor.force_unit` (kgf and N "
            "differ by 9.81) and what else hangs on the sensor."
        ]
    if abs(mass - weighed) < criteria.judging.significant * std:
        return []
    return [
        f"The mass comes out {1e3 * (mass - weighed):+.3g} g beside the weighed one, {abs(mass - weighed) / std:.2g} "
        f"standard deviations. Either something else hangs on the sensor, or all its axes read {100 * share:.2g} % too "
        f"{'much' if more > 0.0 else 'little'}, which no log shows: centre times mass and inertia are then as wrong. "
        f"State `uncertainty: {{ft_gain_common: {share:.2g}}}`, or have the sensor calibrated."
    ]


def told_clocks(payload: Payload) -> list[str]:
    """A sentence for each log whose stamps were replaced."""
    return [
        f"{each.pose.file}, column '{payload.file.time.column}': stamps jitter by {1e3 * each.evened:.2g} ms though "
        "samples were taken evenly, as the pose tells: replaced by the even clock beneath them."
        for each in payload.recordings
        if each.evened > 0.0
    ]


def told_wrench_noise(logs: Logs, stages: Stages) -> list[str]:
    """Channels that scatter by more than is stated; by less in postures, where no motion tells a μ. A wrench in another
    unit than is said scatters so."""
    excitation, holds, payload = stages.excitation, logs.holds, logs.payload
    least, most = logs.criteria.payload_doctor.noise_ratio
    stated = stated_of(payload)
    ratios = std_of(payload) / stated
    if holds is not None and holds.noise is not None and (excitation is None or not excitation.noise_known):
        ratios = np.where(ratios > 1.0, ratios, holds.noise / stated)
    off = [
        f"{name} {ratio:.2g}"
        for name, ratio in zip(payload.file.sensor.wrench, ratios, strict=True)
        if not least <= ratio <= most
    ]
    if not off:
        return []
    taken = "What is more than stated is taken as found. " if ratios.max() > most else ""
    return [
        f"Channels scatter by other multiples of the stated noise than 1: {', '.join(off)}. {taken}`sensor.noise` is "
        "wrong, or `sensor.force_unit` or `sensor.moment_unit` (kgf and N differ by 9.81, Nm and Nmm by a thousand); a "
        "channel that is filtered scatters less."
    ]


def told_noise(logs: Logs) -> list[str]:
    """A sentence for each log whose pose shows more noise than is stated."""
    payload, stated = logs.payload, logs.payload.file.pose.noise_rad
    return [
        f"{recording.pose.file}: a channel of the pose scatters {each.motion.noisier:.2g} times as much as stated "
        f"(`pose.noise_rad` {stated:g}{'' if recording.position is None else ', `noise_m`'}): taken as found. A clock "
        "that is not that of the samples does the same."
        for role, moved in logs.moved.items()
        for recording, each in zip(payload.of(role), moved, strict=True)
        if each.motion.noisier > 1.0
    ]


def doubts(payload: Payload, stages: Stages, rigid: Stages | None, missing: Missing, criteria: Criteria) -> list[str]:
    """What the motion's residual says, and where something touched."""
    excitation, out = stages.excitation, list[str]()
    if excitation is None:
        assert stages.postures is not None
        return said_at_rest(missing, stages.postures.chosen.inclined)
    if excitation.other is not None and missing.decision.verdict == "unexplained":
        assert stages.postures is not None
        (mass, std), before = excitation.other, stages.postures.chosen.mass
        out.append(
            f"Postures say {before:.4g} kg, and another body of {mass:.4g} ± {std:.1g} kg alone explains "
            "the excitation. Was the payload changed, or did it shift in its grip, in between? Hand in what belongs "
            "together."
        )
    if excitation.noise_known:
        mu, mu_std = excitation.chosen.mu, excitation.chosen.mu_std
        beyond, moving_criteria = mu - shown_over_taken(payload, "excitation"), criteria.payload_dynamic
        noisier = beyond < max(moving_criteria.mu_stds * mu_std, moving_criteria.mu_floor)
        reading = reading_of_mu(mu, mu_std, cause_of_residual(missing, noisier), moving_criteria)
        out += [reading] if reading else []
    if missing.late is not None:
        late, std = (1e3 * each for each in missing.late)
        way = "late" if late > 0.0 else "early"
        out.append(
            f"The wrench seems {abs(late):.2g} ± {std:.1g} ms {way} against the pose: too little, or not surely "
            "enough, to be named; the doubt of all numbers holds it."
        )
    if missing.leans is not None:
        lean, std = (float(np.degrees(each)) for each in missing.leans)
        out.append(
            f"The base seems to lean by {lean:.2g} ± {std:.1g}°: too little, or not surely enough, to be named; the "
            "doubt of all numbers holds it. More postures would tell."
        )
    if excitation.left_out and (rigid is not None or not missing.found):
        spans = ", ".join(f"{a:.2f} to {b:.2f} s" for a, b in excitation.left_out[:5])
        out.append(f"Something touched the payload in the excitation; left out: {spans}.")
    return out
