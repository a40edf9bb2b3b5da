"""Where a robot ends: hands, tools, feet."""

from __future__ import annotations

from exogauge.robots.description import Robot
from exogauge.robots.tree import RigidTree

FINGERS = 0.05  # of the robot's mass: what a hand may carry and still be the end


def carries_nothing(tree: RigidTree, body: int) -> bool:
    """Whether no other body hangs on this one, or only fingers' worth of mass: where a payload is carried.

    What hangs behind a force/torque sensor is a hand of its own, however light.
    """
    carried = tree.subtree[body].copy()
    carried[body] = False
    parts = {tree.bodies.index(name) for name in tree.parts}
    return float(tree.phi[carried, 0].sum()) < FINGERS * tree.mass and not parts.intersection(carried.nonzero()[0])


def takes_payload(robot: Robot, body: int) -> bool:
    """Whether it carries nothing, and does not stand on anything: a shank above a light foot, or above the sensor
    at which the robot ends, is no hand."""
    standing = {robot.tree.frames[sensor.frame][0] for sensor in robot.contacts}
    legs = robot.tree.subtree[body].nonzero()[0]
    return carries_nothing(robot.tree, body) and not standing.intersection(legs)
