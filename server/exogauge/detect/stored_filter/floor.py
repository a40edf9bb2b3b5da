"""What the noise floor of logs stands for that were low-passed before they were stored."""

from __future__ import annotations

from collections.abc import Sequence

from exogauge.identification.model import RobotModel
from exogauge.identification.noise_bias import noise_behind_stored
from exogauge.identification.preparation import DRIVE
from exogauge.identification.settings import Recording


def of_the_noise_floor(model: RobotModel, limited: Sequence[Recording], channel: str) -> str:
    """What it stands for: in these logs themselves little noise is left to be seen."""
    if any(each.log.stored is None for each in limited):
        return "The noise floor is what the noise of the other logs leaves behind that low-pass."
    joint = next(each for each in model.robot.joints if channel == f"tau.{each.name}")
    drive = DRIVE[joint.actuation]
    if model.robot.noise.get(drive, 0.0) > 0.0:
        return "The noise floor is what the noise that robot.yaml states leaves behind that low-pass."
    behind = (noise_behind_stored(model.robot, model.prepare(each.log)) for each in limited)
    if all(each[f"{drive}.{joint.name}"] is not None for each in behind):
        return "The noise floor is the sensors' noise behind that low-pass, as seen where that falls off."
    return (
        "There is no noise floor to hold that against: no log shows the sensors' noise, and robot.yaml states none "
        "(`noise`). The one given is that of rounding."
    )
