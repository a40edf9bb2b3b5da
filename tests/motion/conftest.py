"""The sample robot on two feet, as its files describe it."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from exogauge.motion.robot_file import load_motion_robot
from exogauge.robots.moving.robot import MotionRobot
from exogauge.synthetic.urdf import robot_file, robot_urdf


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("robot")
    (made / "robot.urdf").write_text(robot_urdf())
    (made / "robot.yaml").write_text(yaml.safe_dump(dict(robot_file())))
    return made


@pytest.fixture(scope="module")
def robot(folder: Path) -> MotionRobot:
    return load_motion_robot(folder / "robot.yaml")
