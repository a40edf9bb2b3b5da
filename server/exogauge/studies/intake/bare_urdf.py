"""A robot known by nothing but its URDF: enough to look at where bands run, not to identify anything."""

from __future__ import annotations

import numpy as np

from exogauge.errors import BadRobot, Fault
from exogauge.robots.description import Joint, Robot
from exogauge.robots.urdf import load_tree
from exogauge.robots.urdf_check import MOVING_TYPES, read_urdf


def robot_of_urdf(urdf: bytes, file: str) -> Robot:
    """Every joint that moves and mimics no other, in the URDF's order; the root link is the base, and stands still.

    Raises BadRobot.
    """
    description = read_urdf(urdf, file)
    joints = [
        joint.get("name", "")
        for joint in description.findall("joint")
        if joint.get("type") in MOVING_TYPES and joint.find("mimic") is None
    ]
    if not joints:
        raise BadRobot(Fault("no joint of the URDF moves, so no band can act on one", "no_joint", "", file))
    children = {child.get("link") for joint in description.findall("joint") for child in joint.findall("child")}
    names = [link.get("name", "") for link in description.findall("link")]
    root = next(name for name in names if name not in children)
    tree = load_tree(urdf, joints=joints, base_link=root, floating=False, file=file)
    return Robot(
        name=description.get("name") or file,
        tree=tree,
        joints=tuple(Joint(name, "none") for name in joints),
        T_base_imu=None,
        sensors=(),
        axes_from_joints=np.eye(len(joints)),
    )
