"""What the noise floor of logs stands for that were low-passed before they were stored."""

from __future__ import annotations

from collections.abc import Sequence

from exogauge.findings.basis import FloorOf
from exogauge.identification.model import RobotModel
from exogauge.identification.noise_bias import noise_behind_stored
from exogauge.identification.preparation import DRIVE
from exogauge.identification.settings import Recording


def floor_of(model: RobotModel, limited: Sequence[Recording], channel: str) -> FloorOf:
    """What it stands for: in these logs themselves little noise is left to be seen."""
    if any(each.log.stored is None for each in limited):
        return "other_logs"
    joint = next(each for each in model.robot.joints if channel == f"tau.{each.name}")
    drive = DRIVE[joint.actuation]
    if model.robot.noise.get(drive, 0.0) > 0.0:
        return "stated"
    behind = (noise_behind_stored(model.robot, model.prepare(each.log)) for each in limited)
    return "seen" if all(each[f"{drive}.{joint.name}"] is not None for each in behind) else "rounding"
