"""Which axes a joint's position or torque belongs to, and whose load its position changes."""

from __future__ import annotations

import numpy as np

from exogauge.robots.description import Robot


def coupled(robot: Robot) -> list[set[int]]:
    """Joint -> axes that its position or its torque belongs to."""
    C = robot.axes_from_joints
    return [{int(a) for a in np.flatnonzero((C[:, j] != 0.0) | (C[j] != 0.0))} for j in range(len(C))]


def related(robot: Robot) -> list[set[int]]:
    """Joint -> axes whose load its position changes: of all that it carries, and of all that carry it."""
    tree, own = robot.tree, coupled(robot)
    carried = tree.subtree
    body = {int(tree.dof[i]): i for i in range(len(tree.bodies)) if tree.dof[i] >= 0}
    joints = range(len(robot.joints))
    near = [[k for k in joints if carried[body[j], body[k]] or carried[body[k], body[j]]] for j in joints]
    return [set().union(*(own[k] for k in each)) for each in near]
