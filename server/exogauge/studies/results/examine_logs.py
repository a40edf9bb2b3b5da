"""The doctor's visit to a study's logs: what the robot lets one expect, the findings as entries of results.json, and
which logs are left out for them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from exogauge.criteria.criteria import Criteria
from exogauge.identification.settings import Recording
from exogauge.logs.doctor import Finding, examine
from exogauge.plausibility.examine import OTHER_CLOCK, examine_against_robot
from exogauge.remarks import About, Remark
from exogauge.robots.description import Robot
from exogauge.side_by_side import each as side_by_side
from exogauge.studies.intake.expectation import expectation
from exogauge.studies.results.document import finite
from exogauge.studies.words.notices import Notice, notice
from exogauge.support.settings import WornLog

OF_THE_BASE = ("acc", "gyro", "ft.*", "t")  # where these are wrong, so is what every joint should bear
SLIPS = {  # of a mapping, which every log has, though not every log moves so that it shows
    "acceleration_unit", "gravity_missing", "gyro_in_degrees", "gyro_sign", "gyro_frame", "wrench_sign", "force_unit",
    "couple_first", "degrees",
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
    doubtful = {log for log, finding in errors if finding.channel in OF_THE_BASE}
    trusted = [each.log for each in recordings if each.log.name not in doubtful]
    if any(finding.rule in SLIPS for _, finding in errors):
        trusted = []
    return [
        _entry(log, finding) for log, finding in (*examine_against_robot(robot, trusted, criteria.comparison), *alone)
    ]


def without_other_clocks(
    recordings: Sequence[Recording], findings: Sequence[Mapping[str, Any]], kept: frozenset[str]
) -> tuple[list[Recording], list[Notice]]:
    """The recordings that are used, and what is told of the others. findings: of the doctor. kept: recordings
    that stay, as runs with the device are compared with them.

    All stay where no fitted log would be left.
    """
    late = {each["log"]: float(each["value"]) for each in findings if each["rule"] == OTHER_CLOCK}
    gone = [each for each in recordings if each.log.name in late and each.log.recording not in kept]
    used = [each for each in recordings if each not in gone]
    if not gone or all(each.held_out for each in used):
        return list(recordings), []
    names = tuple(each.log.name for each in gone)
    remark = Remark(About.LOGS_LEFT_OUT, names, tuple((late[name],) for name in names))
    return used, [notice(remark)]


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
