"""The doctor's visit to a study's logs: what the robot lets one expect, the findings as entries of results.json, and
which logs are left out for them.

An identification that explains held-out logs worse than the maker's numbers is none: why, says the doctor.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.criteria import Criteria
from exogauge.errors import BadLog, Fault
from exogauge.findings.result import Discrepancy
from exogauge.identification.preparation import DRIVE, needed_channels
from exogauge.identification.prior import joint_prior
from exogauge.identification.result import Identification, Prediction
from exogauge.identification.settings import Recording, Settings
from exogauge.logs.doctor import Finding, examine
from exogauge.logs.findings import kind_of
from exogauge.logs.shared_samples import shared_samples
from exogauge.logs.signal_rules import SLOWLY_SAMPLED
from exogauge.plausibility.examine import examine_against_robot, examine_one_by_one, looked_at
from exogauge.plausibility.told_as import (
    EFFORT_DELAY,
    IMU_CLOCK,
    IMU_LATE,
    MOVED_ZERO,
    OTHER_CLOCK,
    UNSURE_SIGN,
    WRENCH_CLOCK,
)
from exogauge.remarks import About, Remark
from exogauge.robots.description import Robot
from exogauge.side_by_side import each as side_by_side
from exogauge.studies.intake.expected import expectation
from exogauge.studies.results.plain_values import finite
from exogauge.studies.words.notices import Notice, notice
from exogauge.support.settings import WornLog

OF_THE_BASE = ("acc", "gyro", "ft", "t")  # where these are wrong, so is what every joint should bear
SLIPS = {  # of a mapping, which every log has, though not every log moves so that it shows
    "acceleration_unit", "gravity_missing", "gyro_in_degrees", "gyro_sign", "gyro_frame", "wrench_sign", "force_unit",
    "couple_first", "degrees", "motor_side", "counts",
}  # fmt: skip


def examine_logs(
    robot: Robot, recordings: Sequence[Recording], worn: Sequence[WornLog] = (), criteria: Criteria | None = None
) -> list[dict[str, Any]]:
    """{log, severity, channel, rule, detail, advice, row, value}: first what the robot's description contradicts, then
    log by log what its signals show, worst first. worn: with a device, whose share no description of the robot knows.
    Where signals show a slip that changes what every joint should bear, it is told alone, before any comparison.
    """
    criteria = criteria or Criteria()
    expected = replace(expectation(robot), criteria=criteria.doctor)
    logs = [*(each.log for each in recordings), *(each.log for each in worn)]
    examined = side_by_side(partial(examine, expectation=expected), logs)
    alone = [(log.name, finding) for log, findings in zip(logs, examined, strict=True) for finding in findings]
    errors = [(log, finding) for log, finding in alone if finding.severity == "error"]
    doubtful = {log for log, finding in errors if kind_of(finding.channel) in OF_THE_BASE}
    trusted = [each.log for each in recordings if each.log.name not in doubtful]
    if mapped := any(finding.rule in SLIPS for _, finding in errors):
        trusted = []
    fitted = {each.log.name for each in recordings if not each.held_out}
    against = list(examine_against_robot(robot, trusted, criteria.comparison, fitted))
    slipped = any(each.severity == "error" and kind_of(each.channel) in OF_THE_BASE for _, each in against)
    together = {log.name for log in looked_at(trusted, fitted, criteria.comparison.most_logs)}
    others = [*(log for log in trusted if log.name not in together), *(each.log for each in worn)]
    others = [] if slipped or mapped else [log for log in others if log.name not in doubtful]
    imu_late_s = next((each.value for _, each in against if each.rule == IMU_LATE), None)
    told = {(log, each.rule, each.channel) for log, each in against}  # a slip of all logs is told once
    each_alone = examine_one_by_one(robot, others, criteria.comparison, imu_late_s)
    one_by_one = [(log, each) for log, each in each_alone if (log, each.rule, each.channel) not in told]
    held_out = [*(each.held_out for each in recordings), *(True for _ in worn)]
    shared = shared_samples(logs, held_out, criteria.doctor)
    return [_entry(log, finding) for log, finding in (*shared, *against, *one_by_one, *alone)]


@final
@dataclass(frozen=True)
class Used:
    """The recordings that are fitted and judged by, what of the doctor's findings is about them and about logs with a
    device, and what is told of the others. spoiled: those that are fitted although the doctor holds them for spoiled,
    as no others are."""

    recordings: list[Recording]
    findings: list[Mapping[str, Any]]
    notices: list[Notice]
    spoiled: tuple[str, ...] = ()


def without_spoiled(
    robot: Robot, recordings: Sequence[Recording], findings: Sequence[Mapping[str, Any]], kept: frozenset[str]
) -> Used:
    """findings: of the doctor. kept: recordings that stay, as runs with the device are compared with them.

    All stay where no fitted log would be left.
    """
    against = _spoiling(robot, findings)
    dead = {each["channel"]: each for each in findings if each["rule"] == "position_dead"}
    for each in findings:  # what is dead in one log is so where it stays at the same number
        same = dead.get(each["channel"]) if each["rule"] == "does_not_move" else None
        if same is not None and np.isclose(each["value"], same["value"], rtol=0.0, atol=1e-9):
            against.setdefault(each["log"], same)
    gone = [each for each in recordings if each.log.name in against and each.log.recording not in kept]
    used = [each for each in recordings if each not in gone]
    if gone and all(each.held_out for each in used):
        spoiled = tuple(each.log.name for each in gone if not each.held_out)
        return Used(list(recordings), list(findings), _told_of(spoiled, against, About.SPOILED_FIT), spoiled)
    names = tuple(each.log.name for each in gone)
    late = tuple(name for name in names if against[name]["rule"] == OTHER_CLOCK)
    notices = [notice(Remark(About.LOGS_LEFT_OUT, late, tuple((float(against[each]["value"]),) for each in late)))]
    others = _told_of([each for each in names if each not in late], against, About.LOGS_SPOILED)
    about = [each for each in findings if each["log"] not in names]
    return Used(used, about, [*(notices if late else []), *others])


@final
@dataclass(frozen=True)
class UsedWorn:
    """Logs with a device that the doctor does not hold for spoiled, what is told of the others, and what is against
    each of these."""

    logs: list[WornLog]
    notices: list[Notice]
    faults: Mapping[str, Mapping[str, Any]]

    def about_used(self, findings: Sequence[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
        return [each for each in findings if each["log"] not in self.faults]

    def refused(self) -> BadLog:
        """Where none is left."""
        return BadLog(suspects([{**each, "severity": "error"} for each in self.faults.values()]))


def worn_without_spoiled(robot: Robot, worn: Sequence[WornLog], findings: Sequence[Mapping[str, Any]]) -> UsedWorn:
    """findings: of the doctor. What is wrong in a run with the device alone would all be taken for the device."""
    against = _spoiling(robot, findings)
    gone = {each.log.name: against[each.log.name] for each in worn if each.log.name in against}
    used = [each for each in worn if each.log.name not in gone]
    return UsedWorn(used, _told_of([*gone], gone, About.LOGS_SPOILED), gone)


def late_and_not_in_the_model(
    recordings: Sequence[Recording],
    findings: Sequence[Mapping[str, Any]],
    settings: Settings,
    discrepancy: Discrepancy | None,
) -> list[Notice]:
    """One where efforts, or the IMU, of fitted logs are late, and no effect that is named, or stated, accounts for it:
    what a drive bears at once is then taken for friction and inertia, surely and wrongly."""
    named = [*settings.effects, *(each.effect for each in (discrepancy.findings if discrepancy else ()))]
    more = bool(discrepancy and discrepancy.unexplained)  # of an IMU the doctor's time itself tells whether it is all
    open_still = [rule for rule, of in DELAYS.items() if of not in named or (more and rule == EFFORT_DELAY)]
    fitted = {each.log.name for each in recordings if not each.held_out}
    told = [each for each in findings if each["rule"] in open_still and each["log"] in fitted]
    notices = list[Notice]()
    for rule in open_still:
        late = {each["log"]: each for each in told if each["rule"] == rule}
        notices += _told_of([*late], late, About.LATE_FIT)
    return notices


def unsure_joints(findings: Sequence[Mapping[str, Any]]) -> set[str]:
    """Those of which position and effort may both be turned: what other bodies do to them then has the wrong sign."""
    return {str(each["channel"]).partition(".")[2] for each in findings if each["rule"] == UNSURE_SIGN}


def unsure_coefficients(recordings: Sequence[Recording], findings: Sequence[Mapping[str, Any]]) -> tuple[str, ...]:
    """What stands for each other where friction turns round between the samples of a fitted log."""
    fitted = {each.log.name for each in recordings if not each.held_out}
    slow = any(each["rule"] == SLOWLY_SAMPLED and each["log"] in fitted for each in findings)
    return ("k_d", "tau_c", "tau_s", "J_r") if slow else ()


def _spoiling(robot: Robot, findings: Sequence[Mapping[str, Any]]) -> dict[str, Mapping[str, Any]]:
    """log -> the first finding that spoils it."""
    against, needed = dict[str, Mapping[str, Any]](), _identified_by(robot)
    for each in findings:
        if each["channel"] in needed and (each["severity"] == "error" or each["rule"] in SPOILING):
            against.setdefault(each["log"], each)
    return against


def _identified_by(robot: Robot) -> set[str]:
    """Channels, and what the doctor calls several of them."""
    needed = needed_channels(robot)
    kinds = {kind_of(each) for each in needed}
    sensors = {each.rpartition(".")[0] for each in needed if kind_of(each) == "ft"}
    return {*needed, *kinds, *(f"{kind}.*" for kind in kinds), *sensors, "t", "base"}


def _told_of(logs: Sequence[str], against: Mapping[str, Mapping[str, Any]], about: About) -> list[Notice]:
    """One for all logs that have the same against them."""
    alike = dict[tuple[str, str], list[str]]()
    for log in logs:
        alike.setdefault((against[log]["channel"], against[log]["rule"]), []).append(log)
    found = []
    for (channel, _), names in alike.items():
        first = against[names[0]]
        advice = str(first["advice"]).rstrip(".") or "look at that channel"
        found.append(notice(Remark(about, tuple(names), beside=(f"{channel} {first['detail']}", advice))))
    return found


def _entry(log: str, finding: Finding) -> dict[str, Any]:
    return {
        "log": log,
        "severity": finding.severity,
        "channel": finding.channel,
        "rule": finding.rule,
        "detail": finding.detail,
        "advice": finding.advice,
        "row": finding.row,
        "value": finite(finding.value),
    }


Array = NDArray[np.float64]

DELAYS = {EFFORT_DELAY: "torque_delay", IMU_LATE: "imu_delay"}  # rule of the doctor -> the effect
SPOILING = {OTHER_CLOCK, WRENCH_CLOCK, IMU_CLOCK, MOVED_ZERO, "position_dead"}  # beside what is an error
WORSE = 1.1  # times the error of the maker's numbers
NOTHING = 0.02  # of a channel's rms: smaller errors are not compared


def refuse_what_made_it_worse(
    found: Identification, recordings: Sequence[Recording], findings: Sequence[Mapping[str, Any]]
) -> list[Notice]:
    """Raises BadLog with what the doctor holds for an error, if any held-out joint is predicted worse than before.

    Where the doctor has no suspect, the joints are told in a notice: the answer is there, with a doubt. Errors are
    compared in what was measured, amperes where currents were: in N·m a smaller k_T makes any error small.
    """
    worse = {joint: (before, after) for joint, before, after in held_out_errors(found, recordings) if after > before}
    if not worse:
        return []
    joint, (before, after) = max(worse.items(), key=lambda each: each[1][1] / each[1][0])
    said = f"held out, {joint} is predicted worse than by the maker's numbers ({after:.3g} against {before:.3g})"
    if faults := suspects(findings, f"; {said}"):
        raise BadLog(faults)
    return [notice(Remark(About.WORSE_HELD_OUT, tuple(worse)))]


def told_of_errors(robot: Robot, findings: Sequence[Mapping[str, Any]]) -> list[Notice]:
    """That the doctor holds channels for wrong without which the robot could not be identified."""
    needed = needed_channels(robot)
    wrong = {each["channel"] for each in findings if each["severity"] == "error"}
    names = tuple(channel for channel in needed if channel in wrong)
    return [notice(Remark(About.DOCTOR_ERRORS, names))] if names else []


def suspects(findings: Sequence[Mapping[str, Any]], said: str = "") -> list[Fault]:
    """What the doctor holds for an error, each once. said: what it led to."""
    each_once = {(each["channel"], each["rule"]): each for each in findings if each["severity"] == "error"}
    return [
        Fault(f"{each['detail']}{said}", rule, str(each["advice"]), each["log"], column=channel)
        for (channel, rule), each in each_once.items()
    ]


def held_out_errors(found: Identification, recordings: Sequence[Recording]) -> Iterator[tuple[str, float, float]]:
    """(joint, rms error of the maker's numbers, of the identified ones), pooled over held-out logs, as measured.

    In steady motion: at rest and after a turn friction holds a joint with whatever it is asked for, and the maker's
    numbers, without friction, may be nearer by chance.
    """
    logs = {each.log.name: each.log for each in recordings if each.held_out}
    robot = found.model.robot
    coupled = np.abs(robot.axes_from_joints - np.eye(len(robot.joints))).sum(axis=0) > 0.0
    sums = {joint.name: np.zeros(4) for joint in robot.joints}

    def of_log(each: Prediction) -> dict[str, Array]:
        told, found = each.channels(), dict[str, Array]()
        for k, joint in enumerate(robot.joints):
            channel = f"tau.{joint.name}"
            if channel not in told.measured:
                continue
            measured, left = told.measured[channel], told.measured[channel] - told.predicted[channel]
            left_before = told.measured[channel] - told.predicted_prior[channel]
            if joint.actuation == "current" and not coupled[k]:
                current, k_T = logs[each.log].channels[f"{DRIVE['current']}.{joint.name}"], joint_prior(joint, "k_T")
                used = float(measured @ current) / max(float(current @ current), 1e-300)  # N·m/A in which it is told
                left = left / max(abs(used), 1e-6 * k_T)
                measured, left_before = current, current - told.predicted_prior[channel] / k_T
            some = told.steady[channel]
            squares = [float(np.sum(one[some] ** 2)) for one in (left_before, left, measured)]
            found[joint.name] = np.array([*squares, np.count_nonzero(some)])
        return found

    held_out = [each for each in found.predictions if each.log in logs]
    for log_sums in side_by_side(of_log, held_out):
        for name, each in log_sums.items():
            sums[name] += each
    for name, (*squares, count) in sums.items():
        if count:
            was, now, whole = (float(each) for each in np.sqrt(np.array(squares) / count))
            yield name, WORSE * was + NOTHING * whole, now
