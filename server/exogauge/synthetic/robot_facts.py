"""`hrp4_like`: a humanoid of our own, drawn from what is published of HRP-4 (1.51 m, 39 kg, 34 joints).

One table of links from which both the a-priori robot (URDF) and the true one (MJCF) are written. At zero posture every
link frame is parallel to the base frame: x forward, y left, z up. Shapes, masses and drives are our estimates.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, final

Vector = tuple[float, float, float]
Shape = Literal["box", "cylinder", "ellipsoid"]
Axis = Literal["x", "y", "z"]
AXES: dict[Axis, Vector] = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}

NAME = "hrp4_like"
BASE = "BODY"
IMU_FRAME = "imu_link"
FEET = ("l_foot", "r_foot")  # the bodies that carry the force/torque sensors
HIP_DROP, HIP_HALF_WIDTH = 0.08, 0.085  # hip centre below and beside the base frame [m]
THIGH, SHANK = 0.30, 0.30  # [m]
ANKLE_HEIGHT = 0.085  # ankle axes above the ground [m]
SENSOR_DROP = 0.045  # foot sensor below the ankle axes [m]
SOLE_SIZE, SOLE_CENTRE = (0.23, 0.13, 0.03), (0.02, 0.0, -0.025)  # of the sole link, from the sensor frame
CONTACT_BALL = 0.01  # radius [m] of the balls at the corners of a sole, on which it stands


@final
@dataclass(frozen=True)
class Drive:
    """A joint's drive, joint side. k_T [N·m/A], k_d [N·m·s/rad], tau_c, effort [N·m], J_r [kg·m²], velocity [rad/s].

    stiffness, damping: the position controller's gains [N·m/rad, N·m·s/rad].
    """

    k_T: float
    k_d: float
    tau_c: float
    J_r: float
    effort: float
    velocity: float
    stiffness: float
    damping: float
    gear_ratio: float = 100.0


LEG = Drive(6.0, 2.0, 3.0, 0.25, 120.0, 6.0, 6000.0, 90.0)
TORSO = Drive(5.0, 1.5, 2.5, 0.20, 90.0, 5.0, 4500.0, 70.0)
ARM = Drive(3.5, 0.8, 1.2, 0.10, 45.0, 6.0, 900.0, 22.0)
WRIST = Drive(1.5, 0.15, 0.3, 0.015, 10.0, 8.0, 120.0, 3.0)
NECK = Drive(1.5, 0.2, 0.4, 0.02, 10.0, 6.0, 160.0, 4.0)
HAND = Drive(0.4, 0.02, 0.06, 0.002, 2.5, 10.0, 12.0, 0.3)


@final
@dataclass(frozen=True)
class Joint:
    """A revolute joint; lower, upper [rad]."""

    name: str
    axis: Axis
    lower: float
    upper: float
    drive: Drive


@final
@dataclass(frozen=True)
class Link:
    """origin: link frame in the parent's [m], rpy its fixed-axis angles there [rad]; no joint = fixed to the parent.

    size: full extents of the shape [m], centre: its middle in the link frame [m]; mass 0 = a bare frame.
    """

    name: str
    parent: str | None
    origin: Vector
    mass: float = 0.0
    shape: Shape = "box"
    size: Vector = (0.0, 0.0, 0.0)
    centre: Vector = (0.0, 0.0, 0.0)
    joint: Joint | None = None
    rpy: Vector = (0.0, 0.0, 0.0)


def _trunk() -> list[Link]:
    return [
        Link(BASE, None, (0, 0, 0), 5.0, "box", (0.17, 0.24, 0.13), (-0.01, 0.0, -0.01)),
        Link(IMU_FRAME, BASE, (-0.035, 0.02, 0.03), rpy=(0.03, -0.05, 0.10)),
        Link("waist", BASE, (0, 0, 0.06), 1.3, "cylinder", (0.14, 0.14, 0.08), (0, 0, 0.03),
             Joint("torso_yaw", "z", -1.0, 1.0, TORSO)),
        Link("chest", "waist", (0, 0, 0.06), 6.44, "box", (0.18, 0.27, 0.32), (0.01, 0, 0.20),
             Joint("torso_pitch", "y", -0.35, 1.05, TORSO)),
        Link("computer", "chest", (-0.11, 0, 0.24), 1.0, "box", (0.05, 0.20, 0.22)),
        Link("neck", "chest", (0, 0, 0.39), 0.3, "cylinder", (0.07, 0.07, 0.06), (0, 0, 0.02),
             Joint("neck_yaw", "z", -1.2, 1.2, NECK)),
        Link("head", "neck", (0, 0, 0.05), 1.5, "ellipsoid", (0.19, 0.16, 0.19), (0.02, 0, 0.09),
             Joint("neck_pitch", "y", -0.5, 0.7, NECK)),
    ]  # fmt: skip


def _left_leg() -> list[Link]:
    return [
        Link("l_hip_yaw_link", BASE, (0, HIP_HALF_WIDTH, -HIP_DROP), 0.7, "box", (0.09, 0.09, 0.08),
             (-0.02, 0.01, 0.03), Joint("l_hip_yaw", "z", -0.8, 0.8, LEG)),
        Link("l_hip_roll_link", "l_hip_yaw_link", (0, 0, 0), 1.0, "box", (0.12, 0.09, 0.10), (-0.02, 0.01, 0.0),
             Joint("l_hip_roll", "x", -0.6, 0.8, LEG)),
        Link("l_thigh", "l_hip_roll_link", (0, 0, 0), 2.8, "cylinder", (0.11, 0.11, 0.28), (0.01, 0.01, -0.14),
             Joint("l_hip_pitch", "y", -2.0, 0.8, LEG)),
        Link("l_shank", "l_thigh", (0, 0, -THIGH), 2.0, "cylinder", (0.09, 0.09, 0.28), (0.01, 0.0, -0.13),
             Joint("l_knee_pitch", "y", 0.0, 2.5, LEG)),
        Link("l_ankle_link", "l_shank", (0, 0, -SHANK), 0.5, "box", (0.07, 0.07, 0.07), (-0.01, 0.0, 0.0),
             Joint("l_ankle_pitch", "y", -1.3, 1.0, LEG)),
        Link("l_foot", "l_ankle_link", (0, 0, 0), 0.6, "box", (0.12, 0.10, 0.04), (0.01, 0.0, -0.02),
             Joint("l_ankle_roll", "x", -0.8, 0.8, LEG)),
        Link("l_foot_sensor", "l_foot", (0, 0, -SENSOR_DROP)),
        Link("l_sole", "l_foot_sensor", (0, 0, 0), 0.4, "box", SOLE_SIZE, SOLE_CENTRE),
    ]  # fmt: skip


def _left_arm() -> list[Link]:
    return [
        Link("l_shoulder_pitch_link", "chest", (0, 0.165, 0.31), 0.6, "box", (0.08, 0.09, 0.08), (0, 0.01, 0),
             Joint("l_shoulder_pitch", "y", -2.4, 1.2, ARM)),
        Link("l_shoulder_roll_link", "l_shoulder_pitch_link", (0, 0.03, 0), 0.6, "box", (0.08, 0.08, 0.10),
             (0, 0, -0.03), Joint("l_shoulder_roll", "x", -0.2, 1.8, ARM)),
        Link("l_upper_arm", "l_shoulder_roll_link", (0, 0, -0.10), 0.8, "cylinder", (0.07, 0.07, 0.18), (0, 0, -0.06),
             Joint("l_shoulder_yaw", "z", -1.4, 1.4, ARM)),
        Link("l_forearm", "l_upper_arm", (0, 0, -0.15), 0.6, "cylinder", (0.07, 0.07, 0.14), (0.01, 0, -0.05),
             Joint("l_elbow_pitch", "y", -2.2, 0.0, ARM)),
        Link("l_wrist", "l_forearm", (0, 0, -0.12), 0.45, "cylinder", (0.06, 0.06, 0.12), (0, 0, -0.05),
             Joint("l_wrist_yaw", "z", -1.4, 1.4, WRIST)),
        Link("l_wrist_gimbal", "l_wrist", (0, 0, -0.10), 0.15, "box", (0.05, 0.05, 0.04), (0, 0, -0.01),
             Joint("l_wrist_pitch", "y", -0.9, 0.9, WRIST)),
        Link("l_hand", "l_wrist_gimbal", (0, 0, 0), 0.35, "box", (0.04, 0.08, 0.10), (0.01, 0, -0.06),
             Joint("l_wrist_roll", "x", -0.8, 0.8, WRIST)),
        Link("l_thumb", "l_hand", (0.02, -0.03, -0.06), 0.06, "box", (0.02, 0.02, 0.06), (0.005, 0, -0.03),
             Joint("l_hand_thumb", "y", -1.0, 0.4, HAND)),
        Link("l_fingers", "l_hand", (0, 0, -0.11), 0.12, "box", (0.025, 0.07, 0.08), (0.005, 0, -0.04),
             Joint("l_hand_fingers", "y", -1.4, 0.2, HAND)),
    ]  # fmt: skip


def _mirrored(link: Link) -> Link:
    """The right-hand twin of a left link: y, and the signs of roll and yaw limits, turned over."""
    joint = link.joint
    if joint is not None:
        lower, upper = (joint.lower, joint.upper) if joint.axis == "y" else (-joint.upper, -joint.lower)
        joint = replace(joint, name=_right(joint.name), lower=lower, upper=upper)

    def flip(v: Vector) -> Vector:
        return (v[0], -v[1], v[2])

    return replace(link, name=_right(link.name), parent=link.parent and _right(link.parent), origin=flip(link.origin),
                   centre=flip(link.centre), joint=joint)  # fmt: skip


def _right(name: str) -> str:
    return f"r_{name[2:]}" if name.startswith("l_") else name


def _links() -> tuple[Link, ...]:
    left_leg, left_arm = _left_leg(), _left_arm()
    right_leg, right_arm = map(_mirrored, left_leg), map(_mirrored, left_arm)
    return (*_trunk(), *left_arm, *right_arm, *left_leg, *right_leg)


LINKS: tuple[Link, ...] = _links()  # parents before children
BY_NAME: dict[str, Link] = {link.name: link for link in LINKS}
JOINTS: tuple[Joint, ...] = tuple(link.joint for link in LINKS if link.joint is not None)
JOINT_NAMES: tuple[str, ...] = tuple(joint.name for joint in JOINTS)
_LIMBS = ("upper_arm", "forearm", "hand", "thigh", "shank", "foot")
HUMAN_MAP: dict[str, str] = {"pelvis": BASE, "thorax": "chest", "head": "head"} | {
    f"{side}_{part}": f"{side}_{part}" for side in "lr" for part in _LIMBS
}  # part of a person -> link
_BENT = {"hip_pitch": -0.35, "knee_pitch": 0.7, "ankle_pitch": -0.35, "elbow_pitch": -0.4}
HOME: dict[str, float] = {"l_shoulder_roll": 0.25, "r_shoulder_roll": -0.25} | {
    f"{side}_{name}": value for side in "lr" for name, value in _BENT.items()
}  # [rad]: standing, knees and elbows a little bent, arms off the trunk
LIMITS: dict[str, float] = {"acceleration": 40.0, "jerk": 2000.0, "torque_share": 0.9}  # of planned motions
