"""The robot that robot.yaml describes, as motions are planned for it."""

from __future__ import annotations

from pathlib import Path

from exogauge.robots.moving.robot import MotionRobot
from exogauge.studies.intake.bundle import Bundle
from exogauge.studies.intake.moving_robot import moving_robot
from exogauge.studies.intake.robot_file import read_robot


def load_motion_robot(path: Path, *, beside: bool = False) -> MotionRobot:
    """beside: of one's own files, meshes that lie beside its folder too. Raises BadRobot, with the key that is at
    fault."""
    return moving_robot(*read_robot(Bundle(path.parent, path.name), path.name), path, beside=beside)
