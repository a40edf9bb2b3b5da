"""The doctor's visit to a study's logs: what the robot lets one expect, and the findings as entries of results.json."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from exogauge.identification.settings import Recording
from exogauge.logs.doctor import Expectation, JointLimits, examine
from exogauge.robots.description import Robot
from exogauge.studies.results import finite
from exogauge.support.settings import WornLog

STANDARD_GRAVITY = 9.80665


def examine_logs(robot: Robot, recordings: Sequence[Recording | WornLog]) -> list[dict[str, Any]]:
    """{log, severity, channel, rule, detail, advice, row, value}, worst first within a log."""
    expected = expectation(robot)
    return [
        {
            "log": recording.log.name,
            "severity": finding.severity,
            "channel": finding.channel,
            "rule": finding.rule,
            "detail": finding.detail,
            "advice": finding.advice,
            "row": finding.row,
            "value": finite(finding.value),
        }
        for recording in recordings
        for finding in examine(recording.log, expected)
    ]


def expectation(robot: Robot) -> Expectation:
    """Limits from the URDF; the weight where the contact sensors carry a robot with a floating base."""
    tree = robot.tree
    contacts = {sensor.name: sensor.sign for sensor in robot.sensors if sensor.role == "contact"}
    limits = zip(tree.joints, tree.lower.tolist(), tree.upper.tolist(), tree.velocity_limit.tolist(), strict=True)
    return Expectation(
        joints={name: JointLimits(lower, upper, velocity) for name, lower, upper, velocity in limits},
        weight_n=tree.mass * STANDARD_GRAVITY if tree.floating and contacts else None,
        contacts=contacts if tree.floating else {},
        actuation={joint.name: joint.actuation for joint in robot.joints},
        noise=robot.noise,
    )
