"""The sorts of robot that cases are made of, on tables of links of our own.

`arm6`: an arm with six joints on a fixed base. `torso8`: the upper body of `hrp4_like` on a force/torque sensor that is
bolted to the ground; it wears bands down the back, round the waist, and from the trunk to the upper arms.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import final

from exogauge.synthetic.robot_facts import BASE, IMU_FRAME, LINKS, Drive, Joint, Link, Vector


@final
@dataclass(frozen=True)
class WristOrBase:
    """A force/torque sensor that carries all links beyond its frame, which is a link of the robot without a mass.

    force [N], moment [N·m]: noise of one sample.
    """

    name: str
    frame: str
    force: float
    moment: float


@final
@dataclass(frozen=True)
class RobotKind:
    """links: parents before children, the base first. hands: links that take a payload.

    drawn: least and most mass [kg] of links that are another in every case. wires: where bands could run, by group;
    none where the robot wears no device.
    """

    name: str
    links: tuple[Link, ...]
    sensor: WristOrBase
    hands: tuple[str, ...]
    drawn: dict[str, tuple[float, float]] = field(default_factory=dict)
    wires: tuple[Wire, ...] = ()


WRIST_FRAME = "wrist_ft"  # of the force/torque sensor that carries the tool

_LARGE = Drive(k_T=12.0, k_d=9.0, tau_c=7.0, J_r=1.2, effort=160.0, velocity=3.0, stiffness=0.0, damping=0.0)
_MIDDLE = replace(_LARGE, k_T=9.0, k_d=5.0, tau_c=4.5, J_r=0.6, effort=100.0, gear_ratio=80.0)
_SMALL = replace(_LARGE, k_T=5.0, k_d=1.8, tau_c=1.8, J_r=0.15, effort=35.0, gear_ratio=60.0)
_LINKS = (
    Link("base", None, (0, 0, 0), 4.0, "cylinder", (0.16, 0.16, 0.12), (0, 0, 0.05)),
    Link("shoulder", "base", (0, 0, 0.12), 3.6, "cylinder", (0.14, 0.14, 0.16), (0.01, 0.02, 0.03),
         Joint("joint_1", "z", -2.4, 2.4, _LARGE)),
    Link("upper_arm", "shoulder", (0, 0.12, 0.06), 8.0, "box", (0.11, 0.10, 0.44), (0.01, 0.02, 0.19),
         Joint("joint_2", "y", -1.4, 1.4, _LARGE)),
    Link("forearm", "upper_arm", (0, -0.09, 0.42), 3.2, "box", (0.09, 0.08, 0.28), (0.01, -0.01, 0.11),
         Joint("joint_3", "y", -2.0, 2.0, _MIDDLE)),
    Link("forearm_roll", "forearm", (0, 0, 0.22), 1.6, "cylinder", (0.08, 0.08, 0.16), (0.005, 0.02, 0.07),
         Joint("joint_4", "z", -2.6, 2.6, _SMALL)),
    Link("wrist", "forearm_roll", (0, 0, 0.17), 1.3, "box", (0.08, 0.09, 0.11), (0.01, -0.01, 0.03),
         Joint("joint_5", "y", -1.9, 1.9, _SMALL)),
    Link("flange", "wrist", (0, 0, 0.09), 0.4, "cylinder", (0.07, 0.07, 0.04), (0, 0, 0.01),
         Joint("joint_6", "z", -2.8, 2.8, replace(_SMALL, k_T=4.0, k_d=1.0, tau_c=1.2, J_r=0.08))),
    Link(WRIST_FRAME, "flange", (0, 0, 0.03)),
    Link("tool", WRIST_FRAME, (0, 0, 0), 1.5, "box", (0.07, 0.10, 0.14), (0.06, 0.03, 0.07)),
)  # fmt: skip

ARM = RobotKind(
    "arm6",
    _LINKS,
    WristOrBase("wrist", WRIST_FRAME, force=0.1, moment=0.005),
    hands=("tool",),
    drawn={"tool": (0.5, 2.0)},
)


@final
@dataclass(frozen=True)
class Wire:
    """A band's course: straight from point to point. points: link, and xyz [m] in its frame, at the nominal size."""

    name: str
    group: str
    points: tuple[tuple[str, Vector], ...]


_LEFT = (
    Wire("A_left", "A", (("chest", (-0.02, 0.085, 0.35)), ("chest", (-0.13, 0.075, 0.24)),
                         ("waist", (-0.125, 0.05, 0.03)), (BASE, (-0.12, 0.07, -0.05)))),
    Wire("B_left", "B", ((BASE, (-0.12, 0.08, 0.02)), (BASE, (-0.08, 0.145, 0.05)), ("chest", (0.10, 0.16, 0.05)),
                         ("chest", (0.13, 0.09, 0.09)))),
    Wire("C_left", "C", (("chest", (-0.09, 0.05, 0.30)), ("chest", (-0.10, 0.12, 0.20)),
                         ("l_upper_arm", (-0.06, 0.0, -0.12)))),
    Wire("D_left", "D", (("chest", (0.10, 0.05, 0.20)), ("chest", (0.09, 0.12, 0.27)),
                         ("l_upper_arm", (0.045, 0.0, -0.07)))),
)  # fmt: skip


def _mirrored(wire: Wire) -> Wire:
    points = tuple((f"r_{at[2:]}" if at.startswith("l_") else at, (x, -y, z)) for at, (x, y, z) in wire.points)
    return replace(wire, name=wire.name.replace("left", "right"), points=points)


WIRES = tuple(twin for wire in _LEFT for twin in (wire, _mirrored(wire)))


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
