"""Under which effect, and where, a number of the maker is named that data contradict."""

from __future__ import annotations

from exogauge.detect.nominal.contradicted import Change
from exogauge.findings.result import Place
from exogauge.identification.model import RobotModel
from exogauge.robots.ends import takes_payload


def effect_and_place(model: RobotModel, change: Change) -> tuple[str, Place]:
    """More than stated at a hand is a payload. Any other link, and a lighter hand, has a wrong mass."""
    robot, index = model.robot, change.stated.index
    if not change.of_link:
        return "kt_gain", Place("joint", robot.joints[index].name)
    heavier = change.value[0] > 0.0
    effect = "payload" if heavier and takes_payload(robot, index) else "link_mass"
    return effect, Place("link", robot.tree.bodies[index])
