"""Where feet stand flat, the floor tells how the base tilts, and both soles stay at rest: so an accelerometer in the
world's axes is known, and a leg's joint whose axis is reversed."""

from __future__ import annotations

import pytest
from tests.plausibility.standing import record, standing

from exogauge.plausibility.examine import examine_against_robot, examine_one_by_one

pytestmark = pytest.mark.slow


def test_a_body_that_tilts_over_flat_feet_raises_no_doubt() -> None:
    robot, logs = standing(), [record(1), record(2)]
    assert list(examine_against_robot(robot, logs)) == []
    assert list(examine_one_by_one(robot, logs)) == []


def test_an_accelerometer_in_the_worlds_axes_is_told_with_a_device_too() -> None:
    robot, logs = standing(), [record(1, in_world=True), record(2, in_world=True)]
    expected = {(log.name, "acc", "acceleration_in_world", "error") for log in logs}
    for found in (examine_against_robot(robot, logs), examine_one_by_one(robot, logs)):
        assert {(log, each.channel, each.rule, each.severity) for log, each in found} == expected


@pytest.mark.parametrize("joint", ["left_roll", "right_hip", "left_knee", "right_ankle"])
def test_a_legs_joint_whose_axis_is_reversed_is_named_and_not_the_imu(joint: str) -> None:
    robot, logs = standing(turned=(joint,)), [record(1), record(2)]
    expected = {(log.name, f"q.{joint}", "position_reversed", "error") for log in logs}
    for found in (examine_against_robot(robot, logs), examine_one_by_one(robot, logs)):
        assert {(log, each.channel, each.rule, each.severity) for log, each in found} == expected
