"""Under which effect, and where, a number of the maker is named that data contradict."""

from __future__ import annotations

from exogauge.discrepancy.contradicted import Change
from exogauge.discrepancy.result import Place
from exogauge.identification.model import RobotModel
from exogauge.robots.tree import RigidTree

FINGERS = 0.05  # of the robot's mass: what a hand may carry and still be the end


def effect_and_place(model: RobotModel, change: Change) -> tuple[str, Place]:
    """More than stated at a hand is a payload. Any other link, and a lighter hand, has a wrong mass."""
    robot, index = model.robot, change.stated.index
    if not change.of_link:
        return "kt_gain", Place("joint", robot.joints[index].name)
    heavier = change.value[0] > 0.0
    effect = "payload" if heavier and carries_nothing(robot.tree, index) else "link_mass"
    return effect, Place("link", robot.tree.bodies[index])


def carries_nothing(tree: RigidTree, body: int) -> bool:
    """Whether no other body hangs on this one, or only fingers' worth of mass: where a payload is carried.

    What hangs behind a force/torque sensor is a hand of its own, however light.
    """
    carried = [k for k in range(len(tree.bodies)) if tree.parent[k] == body]
    light = float(sum(tree.phi[k, 0] for k in carried)) < FINGERS * tree.mass
    last = not any(tree.parent[k] in carried for k in range(len(tree.bodies)))
    return light and last and not any(tree.bodies[k] in tree.parts for k in carried)
