"""Robots that a preset knows: they stand on their soles, touch nothing at home, and bend."""

from __future__ import annotations

import shutil
from importlib.metadata import distribution
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from tests.motion.robots import STOCK

from exogauge.cli import main
from exogauge.motion.robot_file import load_motion_robot
from exogauge.robots.moving.touching import Pairs

SHARED = Path(__file__).parents[3] / "shared" / "data"
CAPTURES = SHARED / "cmu_mocap_bend_twist"
URDF = {
    "talos": Path(str(distribution("example-robot-data").locate_file(f"{STOCK}/talos_data/robots/talos_reduced.urdf"))),
    "jvrc1": SHARED / "model_jvrc1" / "jvrc_description" / "urdf" / "jvrc1.urdf",
    "ergocub": SHARED / "model_ergocub_urdf" / "ergoCubSN001.urdf",
}
MASS = {"talos": 90.3, "jvrc1": 62.4, "ergocub": 56.7}  # [kg] as their makers and the models' descriptions say
TORSO = {"talos": 2, "jvrc1": 3, "ergocub": 3}


def preset(name: str, folder: Path) -> Path:
    """robot.yaml as the command writes it."""
    if not URDF[name].is_file():
        pytest.skip(f"the model of {name} is not there: {URDF[name].name}")
    shutil.copy(URDF[name], folder / "robot.urdf")
    assert main(["motion", "robot", str(folder / "robot.urdf")]) == 0
    return folder / "robot.yaml"


@pytest.mark.parametrize("name", list(URDF))
def test_a_known_robot_stands_and_touches_nothing(name: str, tmp_path: Path, capsys) -> None:
    robot = load_motion_robot(preset(name, tmp_path))
    assert f"robot                    {name}" in capsys.readouterr().out
    assert robot.mass == pytest.approx(MASS[name], abs=0.1)
    assert len(robot.torso) == TORSO[name]
    pin.forwardKinematics(robot.model, robot.data, robot.home)
    for sole, side in zip(robot.soles, (1.0, -1.0), strict=True):
        at = pin.updateFramePlacement(robot.model, robot.data, robot.frame(sole.link))
        corners = sole.outline @ at.rotation.T + at.translation
        assert np.abs(corners[:, 2]).max() < 1e-6  # flat on the floor, though the knees are bent
        assert (side * corners[:, 1] > 0.0).all()
    whole = pin.centerOfMass(robot.model, robot.data, robot.home)
    assert corners[:, 0].min() + 0.02 < whole[0] < corners[:, 0].max() - 0.02
    pairs = Pairs(robot, 0.01)
    assert robot.shapeless == ()
    assert len(pairs.names) > 90
    arms = ("arm", "ELBOW", "WRIST", "SHOULDER", "wrist")
    for pair in pairs.left_out:  # what lies on each other by construction: never two limbs, nor a limb and the trunk
        assert sum(any(part in link for part in arms) for link in pair) != 1


def test_a_robot_that_no_preset_knows_is_told(tmp_path: Path, capsys) -> None:
    urdf = tmp_path / "other.urdf"
    urdf.write_text('<robot name="other"><link name="base"/></robot>')
    assert main(["motion", "robot", str(urdf)]) == 2
    assert "talos, jvrc1, ergocub" in capsys.readouterr().err
    assert main(["motion", "robot", str(urdf), "--preset", "talos"]) == 2
    assert not (tmp_path / "robot.yaml").exists()
