"""Two arms on one base: what is exchanged between them is told, also where it shows at other joints alone."""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree import ElementTree

import numpy as np
import pytest
from tests.fuzz.small_robots import JOINTS, K_T, simulate
from tests.identification.conftest import chain_urdf
from tests.plausibility.test_examine import as_log

from exogauge.logs.findings import Finding
from exogauge.plausibility.examine import examine_against_robot
from exogauge.robots.description import Robot
from exogauge.studies.intake.robot_file import load_robot

Columns = dict[str, np.ndarray]
SIDES = ("left", "right")
ARMS = tuple(f"{side}_{joint}" for side in SIDES for joint in JOINTS)


def two_arms() -> bytes:
    """The small arm twice, on one base."""
    both = ElementTree.Element("robot", name="two_arms")
    ElementTree.SubElement(both, "link", name="base")
    for side in SIDES:
        for part in ElementTree.fromstring(chain_urdf(len(JOINTS))):
            for each in (part, *part):
                for key in {"name", "link"} & set(each.keys()):
                    each.set(key, each.get(key) if each.get(key) == "base" else f"{side}_{each.get(key)}")
            if part.get("name") != "base":
                both.append(part)
    return ElementTree.tostring(both)


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    folder = tmp_path_factory.mktemp("two_arms")
    (folder / "robot.urdf").write_bytes(two_arms())
    joints = "".join(
        f"  - {{name: {name}, actuation: current, gear_ratio: 80, prior: {{k_T: {k_T:.4g}}}}}\n"
        for name, k_T in zip(ARMS, 0.9 * np.tile(K_T, 2), strict=True)
    )
    (folder / "robot.yaml").write_text(f"version: 1\nurdf: robot.urdf\nbase: fixed\njoints:\n{joints}")
    return load_robot(folder)


@pytest.fixture(scope="module")
def logs() -> list[Columns]:
    """Each arm moves by itself: on a fixed base neither bears the other."""
    found = []
    for number in range(2):
        each = {side: simulate(False, 20 + 2 * number + k, 15.0) for k, side in enumerate(SIDES)}
        columns = {f"{kind}.{side}_{joint}": each[side][f"{kind}.{joint}"]
                   for kind in "qi" for side in SIDES for joint in JOINTS}  # fmt: skip
        found.append({"t": each["left"]["t"]} | columns)
    return found


def said(robot: Robot, logs: Sequence[Columns]) -> dict[tuple[str, str], Finding]:
    found = examine_against_robot(robot, [as_log(k, each) for k, each in enumerate(logs)])
    return {(finding.rule, finding.channel): finding for _, finding in found}


def swapped(columns: Columns, kinds: str, joints: Sequence[str]) -> Columns:
    one, other = ([f"{kind}.{side}_{joint}" for kind in kinds for joint in joints] for side in SIDES)
    both = [*one, *other]
    return columns | {name: columns[its] for name, its in zip(both, [*other, *one], strict=True)}


def test_of_two_arms_as_they_are_nothing_is_said(robot: Robot, logs: list[Columns]) -> None:
    assert said(robot, logs) == {}


RULE = {"q": "positions_exchanged", "i": "efforts_exchanged", "qi": "joints_exchanged"}
OF_ONE_JOINT = [("q", "j1"), ("q", "j2"), ("i", "j3"), ("qi", "j2")]


@pytest.mark.parametrize(("kinds", "joint"), OF_ONE_JOINT)
def test_one_joint_of_the_two_arms_exchanged_is_told(robot: Robot, logs: list[Columns], kinds: str, joint: str) -> None:
    ((told, finding),) = said(robot, [swapped(each, kinds, [joint]) for each in logs]).items()
    assert told[0] == RULE[kinds]
    assert all(f"{side}_{joint}" in told[1] + finding.detail for side in SIDES)


@pytest.mark.slow
@pytest.mark.parametrize("kinds", ["q", "i"])
def test_whole_arms_exchanged_are_one_finding(robot: Robot, logs: list[Columns], kinds: str) -> None:
    """The two arms are built alike: whether positions or currents are the other arm's, no log tells."""
    ((told, finding),) = said(robot, [swapped(each, kinds, JOINTS) for each in logs]).items()
    assert told[0] in ("positions_exchanged", "efforts_exchanged")
    assert "cannot tell which" in finding.detail
    assert all(f"{side}_{JOINTS[k]}" in told[1] + finding.detail for side in SIDES for k in (0, -1))


@pytest.mark.parametrize("zero", [0.8, -0.8])
def test_a_zero_that_is_off_is_told_with_about_its_angle(robot: Robot, logs: list[Columns], zero: float) -> None:
    name = "q.left_j2"
    ((told, finding),) = said(robot, [each | {name: each[name] + zero} for each in logs]).items()
    assert told == ("position_offset", name)
    assert finding.value == pytest.approx(zero, abs=np.radians(16.0))


def test_one_current_of_another_clock_is_told_with_its_time(robot: Robot, logs: list[Columns]) -> None:
    name = "i.right_j2"
    late = [each | {name: np.interp(each["t"] - 0.2, each["t"], each[name])} for each in logs]
    ((told, finding),) = said(robot, late).items()
    assert told == ("effort_delay", name)
    assert finding.value == pytest.approx(0.2, abs=0.02)
    assert "another clock" in finding.advice
