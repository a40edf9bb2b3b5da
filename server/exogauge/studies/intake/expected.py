"""What a log of a robot should look like."""

from __future__ import annotations

from exogauge.logs.findings import Expectation, JointLimits
from exogauge.logs.units import STANDARD_GRAVITY
from exogauge.robots.description import Robot


def expectation(robot: Robot) -> Expectation:
    """Limits from the URDF; the weight where the contact sensors carry a robot with a floating base."""
    tree = robot.tree
    contacts = {sensor.name: sensor.sign for sensor in robot.sensors if sensor.role == "contact"}
    limits = zip(tree.joints, tree.lower.tolist(), tree.upper.tolist(), tree.velocity_limit.tolist(), strict=True)
    gears = {joint.name: abs(joint.gear_ratio or 1.0) for joint in robot.joints}
    slides = {tree.joints[dof] for dof in tree.dof[tree.prismatic & (tree.dof >= 0)]}
    return Expectation(
        joints={
            name: JointLimits(lower, upper, velocity, gears.get(name, 1.0), name not in slides)
            for name, lower, upper, velocity in limits
        },
        weight_n=tree.mass * STANDARD_GRAVITY if tree.floating and contacts else None,
        contacts=contacts if tree.floating else {},
        actuation={joint.name: joint.actuation for joint in robot.joints},
        noise=robot.noise,
    )
