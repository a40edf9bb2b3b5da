"""`torso8`: the upper body of `hrp4_like` on a force/torque sensor; the base stands still and carries an IMU.

Waist, chest and both arms down to the elbows move, eight joints; head, wrists and hands are held.
"""

from __future__ import annotations

from dataclasses import replace

from exogauge.blind.generator.robot_kind import Mount, RobotKind
from exogauge.synthetic.robot_facts import BASE, IMU_FRAME, LINKS, Link

MOUNT = "mount"
_MOVING = (
    "torso_yaw", "torso_pitch", "l_shoulder_pitch", "l_shoulder_roll", "l_elbow_pitch",
    "r_shoulder_pitch", "r_shoulder_roll", "r_elbow_pitch",
)  # fmt: skip
_LEG = ("hip", "thigh", "shank", "ankle", "foot", "sole")


def _held(link: Link) -> Link:
    """Without its joint, if that does not move here; the IMU without its tilt."""
    joint = link.joint if link.joint is not None and link.joint.name in _MOVING else None
    return replace(link, joint=joint, rpy=(0.0, 0.0, 0.0))


_UPPER_BODY = tuple(_held(link) for link in LINKS if not any(part in link.name for part in _LEG))
TORSO = RobotKind("torso8", (*_UPPER_BODY, Link(MOUNT, BASE, (0.0, 0.0, -0.08))), Mount(MOUNT, IMU_FRAME))
