"""An arm that hangs on a wall, described as if it stood on a table: gravity is named, and no joint for it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.plausibility.long_arm import Columns, long_arm, record
from tests.plausibility.test_examine import as_log

from exogauge.logs.findings import Finding
from exogauge.plausibility.examine import examine_against_robot
from exogauge.robots.description import Robot


@pytest.fixture(scope="module")
def logs() -> list[Columns]:
    return [record(seed) for seed in (1, 2, 3)]


def told(robot: Robot, logs: list[Columns]) -> list[Finding]:
    found = [each for _, each in examine_against_robot(robot, [as_log(k, each) for k, each in enumerate(logs)])]
    return [each for each in found if (each.rule, each.severity) != ("sign_unsure", "note")]


@pytest.mark.parametrize(
    ("rpy", "down"),
    [((np.pi / 2, 0, 0), "[0, 1, 0]"), ((0, -np.pi / 2, 0), "[1, 0, 0]"), ((np.pi, 0, 0), "[0, 0, 1]"),
     ((np.pi / 4, 0, 0), "[0, 0.71, -0.71]")],
)  # fmt: skip
def test_another_mounting_is_named_with_the_direction_of_gravity(
    tmp_path: Path, logs: list[Columns], rpy: tuple[float, ...], down: str
) -> None:
    """It stood upright; its description has it turned: in the axes of the description's first link gravity pulls so."""
    found = told(long_arm(tmp_path, rpy), logs)
    assert {(each.channel, each.rule) for each in found} == {("base", "gravity_direction")}
    assert all(down in each.detail for each in found)


def test_an_arm_as_it_stands_raises_no_doubt(tmp_path: Path, logs: list[Columns]) -> None:
    assert told(long_arm(tmp_path), logs) == []


def test_a_quarter_of_a_turn_about_a_horizontal_pan_may_be_its_zero(tmp_path: Path) -> None:
    """Of an arm that is held by its side another zero of the pan turns gravity, too: no log tells the two apart."""
    side = [record(seed, 20.0, (np.pi / 2, 0.0, 0.0)) for seed in (1, 2, 3)]
    off = [each | {"q.pan": each["q.pan"] + np.pi / 2} for each in side]
    found = told(long_arm(tmp_path, (np.pi / 2, 0.0, 0.0)), off)
    assert {each.rule for each in found} == {"gravity_direction"}
    assert all("q.pan" in each.advice and "90°" in each.detail for each in found)


def test_efforts_without_the_weight_that_a_controller_holds_are_told_as_such(tmp_path: Path) -> None:
    """Bodies in doubt by a quarter explained it away: silent, or a zero was blamed."""
    found = told(long_arm(tmp_path), [record(seed, g=0.0) for seed in (1, 2)])
    assert {(each.channel, each.rule) for each in found} == {("i.*", "gravity_left_out")}


def test_an_angle_far_beyond_its_limits_may_be_the_motors_where_no_gear_is_stated(tmp_path: Path) -> None:
    """A gear of 80 was told as degrees alone, by a factor that no effort had been asked for."""
    turns = record(1)
    (found, *_) = told(long_arm(tmp_path), [turns | {"q.lift": 80.0 * turns["q.lift"]}])
    assert (found.channel, found.rule) == ("q.lift", "position_scale")
    assert "gear_ratio" in found.advice
    assert "unexplained" not in found.detail
