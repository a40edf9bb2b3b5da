"""Two feet whose columns were exchanged are named, and no joint for them; feet as they are raise no doubt."""

from __future__ import annotations

from dataclasses import replace

import pytest
from tests.discrepancy.test_partial_names import AXES, FEET, record, robot  # noqa: F401

from exogauge.logs.model import Log
from exogauge.plausibility.examine import examine_against_robot
from exogauge.robots.description import Robot


@pytest.fixture(scope="module")
def logs() -> list[Log]:
    return [record(seed, 0.0, 0.0) for seed in (4, 5)]


def exchanged(log: Log) -> Log:
    both = {f"ft.{foot}.{axis}": f"ft.{other}.{axis}" for foot, other in (FEET, FEET[::-1]) for axis in AXES}
    return replace(log, channels=log.channels | {name: log.channels[other] for name, other in both.items()})


def said(robot: Robot, logs: list[Log]) -> list[tuple[str, str, str]]:  # noqa: F811
    return [(log, each.channel, each.rule) for log, each in examine_against_robot(robot, logs)]


def test_feet_that_are_exchanged_are_named_and_nothing_else(robot: Robot, logs: list[Log]) -> None:  # noqa: F811
    found = said(robot, [exchanged(each) for each in logs])
    assert found == [(each.name, "ft.left", "wrenches_exchanged") for each in logs]


def test_feet_as_they_are_raise_no_doubt(robot: Robot, logs: list[Log]) -> None:  # noqa: F811
    assert said(robot, logs) == []


def test_a_leg_with_a_wrong_sign_is_no_exchange(robot: Robot, logs: list[Log]) -> None:  # noqa: F811
    turned = [replace(each, channels=each.channels | {"tau.left_leg": -each.channels["tau.left_leg"]}) for each in logs]
    assert {(channel, rule) for _, channel, rule in said(robot, turned)} == {("tau.left_leg", "effort_reversed")}
