"""The sample robot on two feet, as its files describe it; a motion of it, planned once for all files of a process."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml
from tests.motion.plans import bend

from exogauge.motion.plan.asked import Asked
from exogauge.motion.plan.solve import Planned, plan
from exogauge.motion.robot_file import load_motion_robot
from exogauge.robots.moving.robot import MotionRobot
from exogauge.synthetic.urdf import robot_file, robot_urdf


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("robot")
    (made / "robot.urdf").write_text(robot_urdf())
    (made / "robot.yaml").write_text(yaml.safe_dump(dict(robot_file())))
    return made


@pytest.fixture(scope="session")
def robot(folder: Path) -> MotionRobot:
    return load_motion_robot(folder / "robot.yaml")


@pytest.fixture(scope="session")
def bent(robot: MotionRobot) -> tuple[Asked, Planned]:
    asked = bend(robot, 0.9, 2.5)
    return asked, plan(robot, asked)


@pytest.fixture(scope="session")
def brief(robot: MotionRobot) -> tuple[Asked, Planned]:
    asked = bend(robot, 0.6, 1.5)
    return asked, plan(robot, asked)
