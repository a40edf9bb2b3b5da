"""Robots whose URDF says neither where they stand nor what of them must not touch: what it takes to plan for them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, final
from xml.etree import ElementTree

from exogauge.criteria.motion_draft import USUAL
from exogauge.errors import BadRobot, Fault
from exogauge.robots.urdf_check import MOVING_TYPES, read_urdf

Box = tuple[float, float, float, float, float, float]  # from x, y, z to x, y, z [m], in the link's axes
Rod = tuple[float, float, float, float, float]  # middle x, y, z, radius, length without caps along z [m]


@final
@dataclass(frozen=True)
class RobotPreset:
    """links with {side} stand for two; y is the left one's. sole: from x, y to x, y at height z [m] of `foot`.

    sides: what {side} is on the left and on the right. fingers: joints that are not planned, as a pattern. turned: of
    joints whose angle has the other sign on the right. limits: where the URDF states none, as is usual and not as the
    maker states it. source: where sizes come from.
    """

    name: str
    pelvis: str
    thorax: str
    arm: tuple[str, str, str]
    foot: str
    sole: tuple[float, float, float, float, float]
    sides: tuple[str, str]
    fingers: str
    imu: str | None
    home: Mapping[str, float]
    turned: str
    boxes: Mapping[str, Box]
    rods: Mapping[str, Rod]
    source: str
    limits: Mapping[str, float] = field(
        default_factory=lambda: {"acceleration": USUAL.acceleration, "jerk": USUAL.jerk}
    )

    @property
    def links(self) -> set[str]:
        """That a URDF of this robot holds."""
        named = {self.pelvis, self.thorax, self.foot, *self.arm, *self.boxes, *self.rods}
        return {link.format(side=side) for link in named for side in self.sides}


TALOS = RobotPreset(
    "talos", "base_link", "torso_2_link", ("arm_{side}_3_link", "arm_{side}_4_link", "arm_{side}_7_link"),
    "leg_{side}_6_link", (-0.109, -0.062, 0.098, 0.062, -0.107), ("left", "right"), "gripper", None,
    {"leg_{side}_3_joint": -0.4, "leg_{side}_4_joint": 0.8, "leg_{side}_5_joint": -0.4, "arm_{side}_2_joint": 0.3,
     "arm_{side}_4_joint": -0.6}, r"arm_.*_2_joint",
    {"base_link": (-0.198, -0.222, -0.185, 0.111, 0.222, 0.012), "torso_2_link": (-0.214, -0.227, -0.061, 0.092, 0.227,
                                                                                 0.397),
     "leg_{side}_6_link": (-0.116, -0.067, -0.107, 0.105, 0.067, -0.03), "head_2_link": (-0.105, -0.094, 0.083, 0.117,
                                                                                        0.094, 0.285)},
    {"arm_{side}_3_link": (0.01, 0.0, -0.195, 0.07, 0.15), "arm_{side}_4_link": (-0.01, 0.0, -0.11, 0.065, 0.18),
     "arm_{side}_7_link": (0.0, 0.0, -0.14, 0.06, 0.14), "leg_{side}_3_link": (0.0, 0.02, -0.19, 0.085, 0.28),
     "leg_{side}_4_link": (0.0, 0.02, -0.16, 0.075, 0.22)},
    "extents of the collision meshes of example-robot-data 4.1",
)  # fmt: skip
JVRC1 = RobotPreset(
    "jvrc1", "PELVIS_S", "WAIST_R_S", ("{side}_SHOULDER_Y_S", "{side}_ELBOW_P_S", "{side}_WRIST_R_S"),
    "{side}_ANKLE_P_S", (-0.075, -0.042, 0.137, 0.042, -0.107), ("L", "R"), "THUMB|INDEX|LITTLE", "gsensor",
    {"{side}_HIP_P": -0.35, "{side}_KNEE": 0.7, "{side}_ANKLE_P": -0.35, "{side}_ELBOW_P": -0.4,
     "{side}_SHOULDER_R": 0.25}, r".*_SHOULDER_R",
    {"PELVIS_S": (-0.108, -0.143, -0.065, 0.113, 0.143, 0.133),
     "WAIST_R_S": (-0.089, -0.177, -0.06, 0.114, 0.177, 0.375),
     "NECK_P_S": (-0.098, -0.085, -0.017, 0.099, 0.112, 0.212),
     "{side}_ANKLE_P_S": (-0.095, -0.05, -0.107, 0.157, 0.05, -0.03)},
    {"{side}_SHOULDER_Y_S": (-0.01, 0.0, -0.165, 0.05, 0.22), "{side}_ELBOW_P_S": (-0.015, 0.0, -0.11, 0.045, 0.14),
     "{side}_WRIST_Y_S": (0.0, 0.0, -0.08, 0.035, 0.1), "{side}_HIP_Y_S": (0.008, 0.0, -0.23, 0.075, 0.26),
     "{side}_KNEE_S": (0.035, 0.0, -0.16, 0.065, 0.22)},
    "extents of the meshes of jvrc_description",
)  # fmt: skip
ERGOCUB = RobotPreset(
    "ergocub", "root_link", "chest", ("{side}_upper_arm", "{side}_forearm", "{side}_wrist_1"),
    "{side}_ankle_2", (-0.042, -0.05, 0.193, 0.05, -0.072), ("l", "r"), "thumb|index|middle|ring|pinkie|camera", None,
    {"{side}_hip_pitch": 0.3, "{side}_knee": -0.6, "{side}_ankle_pitch": -0.3, "{side}_shoulder_roll": 0.3,
     "{side}_elbow": 0.5}, r"none",
    {"root_link": (-0.09, -0.09, -0.05, 0.08, 0.09, 0.07), "chest": (-0.09, -0.1, -0.03, 0.09, 0.1, 0.2),
     "head": (-0.1, -0.09, -0.03, 0.1, 0.09, 0.2), "{side}_ankle_2": (-0.042, -0.05, -0.072, 0.193, 0.05, -0.02)},
    {"{side}_upper_arm": (0.005, 0.0, -0.06, 0.045, 0.08), "{side}_forearm": (-0.007, 0.0, -0.09, 0.045, 0.11),
     "{side}_wrist_2": (0.0, 0.0, -0.08, 0.04, 0.1), "{side}_upper_leg": (0.005, 0.0, -0.08, 0.055, 0.12),
     "{side}_lower_leg": (0.0, 0.015, -0.16, 0.055, 0.2)},
    "feet from its boxes; the rest guessed about the joints of ergoCubSN001.urdf, whose meshes were not there",
)  # fmt: skip
PRESETS = (TALOS, JVRC1, ERGOCUB)


def known(urdf: bytes, file: str) -> bool:
    """Whether the URDF is of one of them. Raises BadRobot."""
    links = {link.get("name", "") for link in read_urdf(urdf, file).findall("link")}
    return any(each.links <= links for each in PRESETS)


def preset_of(urdf: bytes, file: str, name: str | None = None) -> RobotPreset:
    """The preset of that name; without one, that of the robot whose links the URDF holds. Raises BadRobot."""
    links = {link.get("name", "") for link in read_urdf(urdf, file).findall("link")}
    known = ", ".join(each.name for each in PRESETS)
    for each in PRESETS:
        if name == each.name or (name is None and each.links <= links):
            lacking = sorted(each.links - links)
            if lacking:
                raise BadRobot(Fault("the URDF lacks a link of this preset", "unknown_link",
                                     "Choose another preset, or write robot.yaml by hand", file, None, "--preset",
                                     lacking[0]))  # fmt: skip
            return each
    raise BadRobot(Fault("there is no preset for this robot", "no_preset", f"There are {known}; for others write "
                         "robot.yaml by hand: docs/motion.md", file, None, "--preset", name))  # fmt: skip


def robot_file_of(preset: RobotPreset, urdf: bytes, file: str) -> dict[str, Any]:
    """robot.yaml as a tree of plain values: for motions, with no currents and no torques logged. file: the URDF's
    name."""
    root = read_urdf(urdf, file)
    moving = [joint.get("name", "") for joint in root.findall("joint") if joint.get("type") in MOVING_TYPES]
    joints = [name for name in moving if not re.search(preset.fingers, name)]
    (x0, y0, x1, y1, z), (left, right) = preset.sole, preset.sides
    outline = [[x1, y1, z], [x0, y1, z], [x0, y0, z], [x1, y0, z]]
    shapes: dict[str, list[dict[str, Any]]] = {}
    for side, sign in ((left, 1.0), (right, -1.0)):
        for link, corners in preset.boxes.items():
            low, high = _mirrored(corners, sign if "{side}" in link else 1.0)
            size = [round(b - a, 4) for a, b in zip(low, high, strict=True)]
            middle = [round(0.5 * (a + b), 4) for a, b in zip(low, high, strict=True)]
            shapes[link.format(side=side)] = [{"box": size, "xyz": middle}]
        for link, (x, y, z_, radius, length) in preset.rods.items():
            shapes[link.format(side=side)] = [{"capsule": [radius, length], "xyz": [x, sign * y, z_]}]
    home = {}
    for side in preset.sides:
        for name, value in preset.home.items():
            turns = side == right and re.fullmatch(preset.turned, name.format(side=side))
            home[name.format(side=side)] = -value if turns else value
    parts = {f"{'lr'[k]}_{part}": link.format(side=side) for k, side in enumerate(preset.sides)
             for part, link in zip(("upper_arm", "forearm", "hand"), preset.arm, strict=True)}  # fmt: skip
    imu = {"frame": preset.imu} if preset.imu else {"parent": preset.pelvis, "xyz": [0.0] * 3, "rpy": [0.0] * 3}
    return {
        "version": 1, "name": preset.name, "urdf": file, "base": "floating", "base_link": preset.pelvis, "imu": imu,
        "joints": [{"name": name, "actuation": "none"} for name in joints],
        "soles": [{"link": preset.foot.format(side=side), "outline": outline} for side in preset.sides],
        "limits": dict(preset.limits), "human_map": {"pelvis": preset.pelvis, "thorax": preset.thorax} | parts,
        "home": home, "collision": {"shapes": shapes | _bare(root, shapes)},
    }  # fmt: skip


def _bare(root: ElementTree.Element, shapes: Mapping[str, object]) -> dict[str, list[dict[str, Any]]]:
    """Links with shapes of their own in the URDF, which those of the preset stand in for: none."""
    return {link.get("name", ""): [] for link in root.findall("link")
            if link.find("collision") is not None and link.get("name", "") not in shapes}  # fmt: skip


def _mirrored(corners: Sequence[float], sign: float) -> tuple[list[float], list[float]]:
    low, high = list(corners[:3]), list(corners[3:])
    if sign < 0.0:
        low[1], high[1] = -high[1], -low[1]
    return low, high
