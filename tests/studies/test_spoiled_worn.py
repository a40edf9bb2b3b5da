"""A run with the device on whose feet or IMU are wrong: left out, as all that is wrong in it would be the device's."""

from __future__ import annotations

from dataclasses import replace

import pytest
from tests.discrepancy.test_partial_names import AXES, FEET, record, robot  # noqa: F401

from exogauge.devices.device import Band, Device, ViaPoint
from exogauge.errors import BadLog
from exogauge.identification.settings import Recording
from exogauge.logs.model import Log
from exogauge.robots.description import Robot
from exogauge.studies.results.examine_logs import examine_logs, worn_without_spoiled
from exogauge.support.settings import WornLog

DEVICE = Device("wear", (Band("b", "b", (ViaPoint("trunk", (0.1, 0.0, 0.1)), ViaPoint("reach", (0.1, 0.0, -0.1)))),))


@pytest.fixture(scope="module")
def worn() -> list[WornLog]:
    return [WornLog(record(seed, 0.0, 0.0), "bend", DEVICE) for seed in (4, 5)]


def tared(each: WornLog) -> WornLog:
    """Zeros were taken while the robot stood on its feet."""
    names = [f"ft.{foot}.{axis}" for foot in FEET for axis in AXES]
    own = {name: each.log.channels[name] - each.log.channels[name].mean() for name in names}
    return replace(each, log=replace(each.log, channels=each.log.channels | own))


def used(robot: Robot, worn: list[WornLog]):  # noqa: F811
    return worn_without_spoiled(robot, worn, examine_logs(robot, [], worn))


def test_all_are_used_as_they_are(robot: Robot, worn: list[WornLog]) -> None:  # noqa: F811
    found = used(robot, worn)
    assert (found.logs, found.notices) == (worn, [])


def test_one_whose_feet_were_tared_under_load_is_left_out_and_told(robot: Robot, worn: list[WornLog]) -> None:  # noqa: F811
    found = used(robot, [worn[0], tared(worn[1])])
    assert found.logs == worn[:1]
    (notice,) = found.notices
    assert worn[1].log.name in notice.sentence
    assert worn[0].log.name not in notice.sentence
    assert "zeros taken while the robot stood" in notice.sentence


def test_where_all_are_so_what_is_wrong_is_the_reason(robot: Robot, worn: list[WornLog]) -> None:  # noqa: F811
    found = used(robot, [tared(each) for each in worn])
    assert found.logs == []
    refused = found.refused()
    assert isinstance(refused, BadLog)
    assert "zeros taken while the robot stood" in str(refused)


def test_a_slip_that_all_logs_have_is_told_of_those_without_a_device_and_of_no_other(
    robot: Robot,  # noqa: F811
    worn: list[WornLog],
) -> None:
    turned = {
        f"ft.{foot}.{kind}{axis}": (f"ft.{foot}.{kind}{source}", sign)
        for foot in FEET for kind in "fm" for axis, source, sign in (("x", "y", 1.0), ("y", "x", -1.0))
    }  # fmt: skip

    def slipped(log: Log) -> Log:
        return replace(
            log, channels=log.channels | {name: sign * log.channels[of] for name, (of, sign) in turned.items()}
        )

    bare = [Recording(slipped(record(seed, 0.0, 0.0)), held_out=False) for seed in (6, 7)]
    found = examine_logs(robot, bare, [replace(each, log=slipped(each.log)) for each in worn])
    told = {(each["log"], each["rule"]) for each in found if each["severity"] == "error"}
    assert told == {("log6", "wrench_axes"), ("log7", "wrench_axes")}
