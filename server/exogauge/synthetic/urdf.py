"""The a-priori robot as URDF, and robot.yaml: what an evaluation is told."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any
from xml.etree import ElementTree as Xml

from exogauge.synthetic import sensors
from exogauge.synthetic.inertia import Mass, of_shape
from exogauge.synthetic.robot_facts import (
    AXES,
    BASE,
    CONTACT_BALL,
    FEET,
    HOME,
    HUMAN_MAP,
    IMU_FRAME,
    JOINTS,
    LIMITS,
    LINKS,
    NAME,
    SENSOR_DROP,
    SOLE_CENTRE,
    SOLE_SIZE,
    Link,
)
from exogauge.synthetic.true_robot import INERTIAL_STD, a_priori_joint, a_priori_joint_std


def robot_urdf() -> str:
    """The a-priori robot; link frames at the joints, sensor frames as links without mass."""
    robot = Xml.Element("robot", name=NAME)
    for link in LINKS:
        element = Xml.SubElement(robot, "link", name=link.name)
        if link.mass > 0.0:
            _inertial(element, of_shape(link))
            for use in ("visual", "collision"):
                _geometry(Xml.SubElement(element, use), link)
    for link in LINKS:
        if link.parent is not None:
            _joint(robot, link, link.parent)
    Xml.indent(robot)
    return Xml.tostring(robot, encoding="unicode") + "\n"


def robot_file(
    encoder_step: float = sensors.ENCODER_STEP, uncertainty: Mapping[str, float | str] | str = "none"
) -> Mapping[str, Any]:
    """robot.yaml as a tree of plain values."""
    return {
        "version": 1,
        "uncertainty": uncertainty,
        "name": NAME,
        "urdf": "robot.urdf",
        "base": "floating",
        "base_link": BASE,
        "imu": {"frame": IMU_FRAME},
        "ft_sensors": [
            {"name": foot, "frame": f"{foot}_sensor", "role": "contact", "sees": "world_on_robot"} for foot in FEET
        ],
        "joints": [
            {
                "name": joint.name,
                "actuation": "current",
                "gear_ratio": joint.drive.gear_ratio,
                "prior": _rounded(a_priori_joint(joint.drive).parameters()),
                "prior_std": _rounded(a_priori_joint_std(joint.drive)),
            }
            for joint in JOINTS
        ],
        "noise": {**sensors.NOISE, "q": sensors.position_noise(encoder_step)},
        "inertial_prior_std": {"default": INERTIAL_STD},
        "soles": [{"link": foot, "outline": _outline()} for foot in FEET],
        "collision": {"left_out": [["BODY", "chest"]]},  # boxes; what is round there lets the torso bend to its limit
        "limits": LIMITS,
        "human_map": HUMAN_MAP,
        "home": HOME,
    }


def _outline() -> list[list[float]]:
    """Where a sole stands on the floor, in its foot's frame [m]: below the middles of the balls at its corners."""
    (x, y, z), (a, b, c) = SOLE_CENTRE, (size / 2 for size in SOLE_SIZE)
    a, b = a - CONTACT_BALL, b - CONTACT_BALL
    corners = ((a, b), (-a, b), (-a, -b), (a, -b))
    return [[round(x + dx, 6), round(y + dy, 6), round(z - c - SENSOR_DROP, 6)] for dx, dy in corners]


def _rounded(values: Mapping[str, float]) -> dict[str, float]:
    return {name: float(f"{value:.6g}") for name, value in values.items()}


def _inertial(element: Xml.Element, mass: Mass) -> None:
    inertial = Xml.SubElement(element, "inertial")
    Xml.SubElement(inertial, "origin", xyz=_text(mass.centre), rpy="0 0 0")
    Xml.SubElement(inertial, "mass", value=_text([mass.mass]))
    I = mass.inertia  # noqa: E741
    names = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
    Xml.SubElement(inertial, "inertia", {name: _text([I[at]]) for name, at in names.items()})


def _geometry(element: Xml.Element, link: Link) -> None:
    """URDF knows no ellipsoid: a sphere of its mean extent stands for it."""
    Xml.SubElement(element, "origin", xyz=_text(link.centre), rpy="0 0 0")
    geometry = Xml.SubElement(element, "geometry")
    if link.shape == "box":
        Xml.SubElement(geometry, "box", size=_text(link.size))
    elif link.shape == "cylinder":
        Xml.SubElement(geometry, "cylinder", radius=_text([link.size[0] / 2]), length=_text([link.size[2]]))
    else:
        Xml.SubElement(geometry, "sphere", radius=_text([math.prod(link.size) ** (1 / 3) / 2]))


def _joint(robot: Xml.Element, link: Link, parent: str) -> None:
    joint = link.joint
    name, kind = (joint.name, "revolute") if joint else (f"{link.name}_fixed", "fixed")
    element = Xml.SubElement(robot, "joint", name=name, type=kind)
    Xml.SubElement(element, "parent", link=parent)
    Xml.SubElement(element, "child", link=link.name)
    Xml.SubElement(element, "origin", xyz=_text(link.origin), rpy=_text(link.rpy))
    if joint:
        limits = {"lower": joint.lower, "upper": joint.upper, "effort": joint.drive.effort}
        Xml.SubElement(element, "axis", xyz=_text(AXES[joint.axis]))
        Xml.SubElement(
            element, "limit", {k: _text([v]) for k, v in {**limits, "velocity": joint.drive.velocity}.items()}
        )


def _text(values: Any) -> str:
    return " ".join(f"{float(value):.12g}" for value in values)
