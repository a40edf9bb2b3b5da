"""A robot.yaml drafted from a URDF of another maker is one that its own reader takes, once it is filled in."""

from __future__ import annotations

import re
import sysconfig
from pathlib import Path

import pytest
import yaml

from exogauge.cli import main
from exogauge.errors import BadRobot
from exogauge.studies.import_log.robot_draft import draft_robot, slips
from exogauge.studies.intake.bundle import Bundle
from exogauge.studies.intake.robot_file import read_robot

ROBOTS = Path(sysconfig.get_path("purelib")) / "cmeel.prefix/share/example-robot-data/robots"
G1 = ROBOTS / "g1_description/urdf/g1_29dof_rev_1_0.urdf"
TALOS = ROBOTS / "talos_data/robots/talos_reduced.urdf"
PANDA = ROBOTS / "panda_description/urdf/panda.urdf"


@pytest.mark.parametrize(
    ("urdf", "joints", "feet"),
    [
        (G1, 29, ["left_ankle_roll_link", "right_ankle_roll_link"]),
        (TALOS, 32, ["left_sole_link", "right_sole_link"]),
        (PANDA, 8, []),  # seven, and one finger; the other mimics it
        (ROBOTS / "z1_description/urdf/z1.urdf", 7, []),
    ],
)
def test_a_draft_is_read_again(tmp_path: Path, urdf: Path, joints: int, feet: list[str]) -> None:
    (tmp_path / urdf.name).write_bytes(urdf.read_bytes())
    (tmp_path / "robot.yaml").write_text(draft_robot(urdf.read_bytes(), urdf.name, "torque"))
    robot = read_robot(Bundle(tmp_path, ""), "robot.yaml")[0]
    assert len(robot.joints) == joints
    assert [each.frame for each in robot.contacts] == feet
    assert robot.floating == bool(feet)


def test_feet_that_are_spelled_otherwise_are_feet(tmp_path: Path) -> None:
    """Qinglong, a humanoid on two legs, was drafted as an arm that is bolted down."""
    urdf = re.sub(rb"(left|right)_ankle_roll_link", rb"Link_ankel_\1_roll", G1.read_bytes())
    (tmp_path / "robot.urdf").write_bytes(urdf)
    (tmp_path / "robot.yaml").write_text(draft_robot(urdf, "robot.urdf", "torque"))
    robot = read_robot(Bundle(tmp_path, ""), "robot.yaml")[0]
    assert [each.frame for each in robot.contacts] == ["Link_ankel_left_roll", "Link_ankel_right_roll"]


def test_what_the_urdf_cannot_say_is_asked_for_and_refused_until_it_is_there(tmp_path: Path) -> None:
    text = draft_robot(G1.read_bytes(), G1.name)
    assert "# ! joints: k_T" in text
    assert yaml.safe_load(text)["imu"] == {"frame": "imu_in_pelvis"}
    (tmp_path / G1.name).write_bytes(G1.read_bytes())
    (tmp_path / "robot.yaml").write_text(text)
    with pytest.raises(BadRobot, match="k_T"):
        read_robot(Bundle(tmp_path, ""), "robot.yaml")


def test_masses_that_stand_in_for_what_nobody_knew_are_told() -> None:
    alike = re.sub(rb'<mass value="[^"]+"', b'<mass value="1.0"', PANDA.read_bytes())
    assert any("weighs 1 kg" in each for each in slips(alike, PANDA.name))
    assert not any("weighs" in each for each in slips(PANDA.read_bytes(), PANDA.name))


def test_nothing_is_written_over(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "arm.urdf").write_bytes(PANDA.read_bytes())
    asked = ["robot", str(tmp_path / "arm.urdf"), "--actuation", "torque", "--out", str(tmp_path / "robot.yaml")]
    assert main(asked) == 0
    before = (tmp_path / "robot.yaml").read_text()
    assert main(asked) == 2
    assert "written over" in capsys.readouterr().err
    assert (tmp_path / "robot.yaml").read_text() == before
