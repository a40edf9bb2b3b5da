"""robot.urdf and robot.yaml of the a-priori robot: what an evaluation is told.

The a-priori robot of a case: its maker builds no two alike.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, final
from xml.etree import ElementTree as Xml

import numpy as np

from exogauge.blind.generator import sensors
from exogauge.blind.generator.robot_kind import RobotKind
from exogauge.blind.generator.true_robot import INERTIAL_STD, a_priori, a_priori_std
from exogauge.synthetic.inertia import of_shape
from exogauge.synthetic.robot_facts import AXES, Drive, Joint, Link, Vector


def robot_urdf(name: str, links: Sequence[Link]) -> str:
    robot = Xml.Element("robot", name=name)
    for link in links:
        element = Xml.SubElement(robot, "link", name=link.name)
        if link.mass > 0.0:
            _inertial(element, link)
    for link in links:
        if link.parent is not None:
            _joint(robot, link, link.parent)
    Xml.indent(robot)
    return Xml.tostring(robot, encoding="unicode") + "\n"


def robot_file(kind: RobotKind, links: Sequence[Link], actuation: str, k_T_std: float) -> Mapping[str, Any]:
    """robot.yaml as a tree of plain values. links: as built."""
    joints = [link.joint for link in links if link.joint is not None]
    q_std = float(np.sqrt(np.mean([sensors.encoder_std(joint.drive.gear_ratio) ** 2 for joint in joints])))
    noise = {"q": _number(q_std)} | ({"i": _number(sensors.current_std())} if actuation == "current" else {})
    sensor = kind.sensor
    return {
        "version": 1,
        "uncertainty": "none",
        "name": kind.name,
        "urdf": "robot.urdf",
        "base": "fixed",
        "base_link": links[0].name,
        "ft_sensors": [{"name": sensor.name, "frame": sensor.frame, "role": "cut", "sees": "payload_on_sensor"}],
        "joints": [_joint_entry(joint, actuation, k_T_std) for joint in joints],
        "noise": noise | {"force": sensor.force, "moment": sensor.moment},
        "inertial_prior_std": {"default": INERTIAL_STD},
    }


def _joint_entry(joint: Joint, actuation: str, k_T_std: float) -> dict[str, Any]:
    left_out = () if actuation == "current" else ("k_T",)
    values, spread = (
        {key: _number(value) for key, value in table.items() if key not in left_out}
        for table in (a_priori(joint.drive), a_priori_std(joint.drive, k_T_std))
    )
    gear = joint.drive.gear_ratio
    return {"name": joint.name, "actuation": actuation, "gear_ratio": gear, "prior": values, "prior_std": spread}


def _inertial(element: Xml.Element, link: Link) -> None:
    mass = of_shape(link)
    I = mass.inertia  # noqa: E741
    inertial = Xml.SubElement(element, "inertial")
    Xml.SubElement(inertial, "origin", xyz=_text(mass.centre), rpy="0 0 0")
    Xml.SubElement(inertial, "mass", value=_text([mass.mass]))
    names = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
    Xml.SubElement(inertial, "inertia", {name: _text([I[at]]) for name, at in names.items()})


def _joint(robot: Xml.Element, link: Link, parent: str) -> None:
    joint = link.joint
    name, kind = (joint.name, "revolute") if joint else (f"{link.name}_fixed", "fixed")
    element = Xml.SubElement(robot, "joint", name=name, type=kind)
    Xml.SubElement(element, "parent", link=parent)
    Xml.SubElement(element, "child", link=link.name)
    Xml.SubElement(element, "origin", xyz=_text(link.origin), rpy="0 0 0")
    if joint:
        limits = (joint.lower, joint.upper, joint.drive.effort, joint.drive.velocity)
        Xml.SubElement(element, "axis", xyz=_text(AXES[joint.axis]))
        Xml.SubElement(
            element, "limit",
            {key: _text([value]) for key, value in zip(("lower", "upper", "effort", "velocity"), limits, strict=True)},
        )  # fmt: skip


def _text(values: Any) -> str:
    return " ".join(f"{float(value):.12g}" for value in values)


def _number(value: float) -> float:
    return float(f"{value:.6g}")


VARIES = 0.2  # largest relative deviation of lengths, masses and drives from one case to the next


@final
@dataclass(frozen=True)
class Built:
    """links: of one robot as its maker describes it, parents before children. size: relative to `RobotKind.links`."""

    links: tuple[Link, ...]
    size: float

    @property
    def joints(self) -> list[Joint]:
        return [link.joint for link in self.links if link.joint is not None]


def built(rng: np.random.Generator, kind: RobotKind) -> Built:
    size, weight = 1.0 + VARIES * rng.uniform(-1.0, 1.0, 2)
    links = [_varied(link, size, weight, rng) for link in kind.links]
    drawn = {name: _round(rng.uniform(*ends)) for name, ends in kind.drawn.items()}
    return Built(tuple(replace(link, mass=drawn.get(link.name, link.mass)) for link in links), float(size))


def _varied(link: Link, size: float, weight: float, rng: np.random.Generator) -> Link:
    own = 1.0 + 0.5 * VARIES * rng.uniform(-1.0, 1.0)
    joint = link.joint and replace(link.joint, drive=_varied_drive(link.joint.drive, rng))
    return replace(link, origin=_scaled(link.origin, size), size=_scaled(link.size, size), joint=joint,
                   centre=_scaled(link.centre, size), mass=_round(link.mass * weight * own))  # fmt: skip


def _varied_drive(drive: Drive, rng: np.random.Generator) -> Drive:
    k_T, k_d, tau_c, J_r = 1.0 + VARIES * rng.uniform(-1.0, 1.0, 4)
    return replace(
        drive,
        k_T=_round(drive.k_T * k_T),
        k_d=_round(drive.k_d * k_d),
        tau_c=_round(drive.tau_c * tau_c),
        J_r=_round(drive.J_r * J_r),
    )


def _scaled(vector: Vector, by: float) -> Vector:
    x, y, z = (round(float(value * by), 4) for value in vector)
    return x, y, z


def _round(value: float) -> float:
    return float(f"{value:.4g}")
