"""`torso8`: the upper body of `hrp4_like` on a force/torque sensor that is bolted to the ground; it wears bands.

Waist, chest and both arms down to the elbows move, eight joints; head, wrists and hands are held.
"""

from __future__ import annotations

from dataclasses import replace

from exogauge.blind.generator.robot_kind import RobotKind, WristOrBase
from exogauge.blind.generator.wear_facts import WIRES
from exogauge.synthetic.robot_facts import BASE, IMU_FRAME, LINKS, Link

PEDESTAL, MOUNT = "pedestal", "mount"
_MOVING = (
    "torso_yaw", "torso_pitch", "l_shoulder_pitch", "l_shoulder_roll", "l_elbow_pitch",
    "r_shoulder_pitch", "r_shoulder_roll", "r_elbow_pitch",
)  # fmt: skip
_LEG = ("hip", "thigh", "shank", "ankle", "foot", "sole")
_UNDERNEATH = (
    Link(PEDESTAL, None, (0, 0, 0), 6.0, "box", (0.30, 0.30, 0.10), (0, 0, 0.05)),
    Link(MOUNT, PEDESTAL, (0, 0, 0.12)),
)


def _held(link: Link) -> Link:
    """Without its joint, if that does not move here; the base on its sensor."""
    joint = link.joint if link.joint is not None and link.joint.name in _MOVING else None
    parent, origin = (MOUNT, (0.0, 0.0, 0.08)) if link.name == BASE else (link.parent, link.origin)
    return replace(link, parent=parent, origin=origin, joint=joint)


_UPPER_BODY = tuple(
    _held(link) for link in LINKS if link.name != IMU_FRAME and not any(part in link.name for part in _LEG)
)
TORSO = RobotKind(
    "torso8",
    (*_UNDERNEATH, *_UPPER_BODY),
    WristOrBase(MOUNT, MOUNT, force=0.5, moment=0.04),
    hands=("l_forearm", "r_forearm"),
    wires=WIRES,
)
