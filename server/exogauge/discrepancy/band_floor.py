"""What the noise floor of logs stands for that were low-passed before they were stored."""

from __future__ import annotations

from collections.abc import Sequence

from exogauge.identification.preparation import DRIVE
from exogauge.identification.settings import Recording
from exogauge.robots.description import Robot


def of_the_noise_floor(robot: Robot, limited: Sequence[Recording], channel: str) -> str:
    """What it stands for: in these logs themselves no noise is left to be seen."""
    if any(each.log.stored is None for each in limited):
        return "The noise floor is what the noise of the other logs leaves behind that low-pass."
    joint = next(each for each in robot.joints if channel == f"tau.{each.name}")
    if robot.noise.get(DRIVE[joint.actuation], 0.0) > 0.0:
        return "The noise floor is what the noise that robot.yaml states leaves behind that low-pass."
    return (
        "There is no noise floor to hold that against: no log shows the sensors' noise, and robot.yaml states none "
        "(`noise`). The one given is that of rounding."
    )
