"""A first robot.yaml, by looking at a URDF: joints in its order, the base, and which frames may hold sensors.

What the URDF cannot say (torque per ampere, what a sensor's sign means) is left to be filled in, and said.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, final
from xml.etree.ElementTree import Element

import yaml

from exogauge.criteria.examining import Examining
from exogauge.errors import BadRobot, Fault
from exogauge.robots.urdf_check import (
    MOVING_TYPES,
    idle_joints,
    impossible_density,
    limits_in_degrees,
    masses_alike,
    raised_inertias,
    read_urdf,
)
from exogauge.studies.words.remark_words import sentence

HEAD = "# Drafted from the URDF. Check what is marked ?; fill in what is marked !."
IMU = re.compile(r"imu|inertial|accel", re.I)
SENSOR = re.compile(r"(^|[_\W])(f_?t|fts|force(_?torque)?|wrench|loadcell)([_\W\d]|$)", re.I)
SOLE, FOOT = re.compile(r"sole", re.I), re.compile(r"foot|ankle|ankel|(^|_)ank(_|\d|$)", re.I)  # Qinglong: ankel


@final
@dataclass(frozen=True)
class _Tree:
    """parent: link -> (link, name of the joint). moving: joints that may be driven, in the URDF's order."""

    links: tuple[str, ...]
    parent: dict[str, tuple[str, str]]
    moving: tuple[str, ...]

    @staticmethod
    def of(urdf: Element) -> _Tree:
        parent, moving = dict[str, tuple[str, str]](), list[str]()
        for joint in urdf.findall("joint"):
            above, below, name = joint.find("parent"), joint.find("child"), joint.get("name", "")
            assert above is not None
            assert below is not None
            parent[below.get("link", "")] = above.get("link", ""), name
            if joint.get("type") in MOVING_TYPES and joint.find("mimic") is None:
                moving.append(name)
        return _Tree(tuple(link.get("name", "") for link in urdf.findall("link")), parent, tuple(moving))

    @property
    def root(self) -> str:
        return next(link for link in self.links if link not in self.parent)

    def carrier(self, link: str) -> str:
        """The uppermost link that this one is fixed to."""
        while link in self.parent and self.parent[link][1] not in self.moving:
            link = self.parent[link][0]
        return link

    def ends(self, link: str) -> bool:
        """Whether no joint that moves hangs on it."""
        below = [child for child, (above, _) in self.parent.items() if above == link]
        return all(self.parent[child][1] not in self.moving and self.ends(child) for child in below)


def draft_robot(urdf: bytes, file: str, actuation: str = "current") -> str:
    """The text of a robot.yaml. file: the URDF's name beside it. actuation: of all joints. Raises BadRobot."""
    content, told = drafted(urdf, file, actuation)
    lines = list[str]()
    for key, value in content.items():
        lines += [f"{key}:", *(f"  - {_line(each)}" for each in value)] if isinstance(value, list) else [
            f"{key}: {_line(value)}"]  # fmt: skip
    return "\n".join([HEAD, *told, *slips(urdf, file), *lines, ""])


def drafted(urdf: bytes, file: str, actuation: str) -> tuple[dict[str, Any], list[str]]:
    """What a robot.yaml holds, and comments on what was guessed in it. Raises BadRobot."""
    tree = _Tree.of(read_urdf(urdf, file))
    if not tree.moving:
        raise BadRobot(Fault("no joint of it moves", "no_joint", "Give the URDF of a robot", file))
    told, feet = list[str](), _feet(tree)
    content: dict[str, Any] = {"version": 1, "urdf": file, "base": "floating" if feet else "fixed"}
    if feet:
        told.append(f"# ? base: floating, as it has two feet ({', '.join(feet)}); `fixed` if it is bolted down")
        content |= {"base_link": tree.root, "imu": {"frame": _imu(tree, told)}}
    else:
        told.append("# ? base: fixed, as no two feet were found; `floating` takes base_link and imu as well")
    sensors = [*_contacts(tree, feet, told), *_inside(tree, told)]
    if actuation == "current":
        told.append("# ! joints: k_T is the joint's torque per ampere [N·m/A], from data sheet and gear; 0 is refused")
    beside = {"prior": {"k_T": 0}} if actuation == "current" else {}
    joints = [{"name": name, "actuation": actuation, **beside} for name in tree.moving]
    return content | ({"ft_sensors": sensors} if sensors else {}) | {"joints": joints}, told


def slips(urdf: bytes, file: str) -> list[str]:
    """Comments on what looks like a slip in the URDF itself: units, inertias that no body has, links without mass."""
    from exogauge.robots.urdf import load_whole  # it computes, and the service that reads drafts does not

    tree = load_whole(urdf, file)
    usual = Examining()
    remarks = [*raised_inertias(urdf, file), *impossible_density(urdf, file, usual), *masses_alike(urdf, file)]
    remarks += limits_in_degrees(urdf, file, usual)
    weightless = list[str]()
    try:
        remarks += idle_joints(tree, file)
    except BadRobot as bad:
        weightless = [f"{fault.detail}. {fault.advice}" for fault in bad.faults]
    return [f"# ? urdf: {said}" for said in (*map(sentence, remarks), *weightless)]


def _line(value: object) -> str:
    return yaml.safe_dump(value, sort_keys=False, default_flow_style=True, width=1000).removesuffix("\n...\n").strip()


def _feet(tree: _Tree) -> list[str]:
    """The last links of two legs: a sole if there is one, else a foot or an ankle; nothing where there are not two."""
    ends = [link for link in tree.links if tree.ends(link) and (SOLE.search(link) or FOOT.search(link))]
    by_leg: dict[str, list[str]] = {}
    for link in ends:
        by_leg.setdefault(tree.carrier(link), []).append(link)
    best = [next((link for link in leg if SOLE.search(link)), leg[0]) for leg in by_leg.values()]
    return best if len(best) == 2 else []


def _imu(tree: _Tree, told: list[str]) -> str:
    there = [link for link in tree.links if IMU.search(link) and tree.carrier(link) == tree.root]
    if there:
        told.append(f"# ? imu: {there[0]}, by its name; acc and gyro are in its axes")
        return there[0]
    told.append(f"# ! imu: no link fixed to {tree.root} is called one; name the frame whose axes acc and gyro are in")
    return tree.root


def _contacts(tree: _Tree, feet: Sequence[str], told: list[str]) -> Iterator[dict[str, str]]:
    for link in feet:
        told.append(f"# ? ft_sensors: {link} under a foot; `robot_on_world` if a robot that stands reads its weight")
        yield {"name": link, "frame": link, "role": "contact", "sees": "world_on_robot"}


def _inside(tree: _Tree, told: list[str]) -> Iterator[dict[str, str]]:
    seen = set[str]()  # one for all frames of one body
    for link in tree.links:
        if SENSOR.search(link) and link in tree.parent and tree.carrier(link) not in seen:
            seen.add(tree.carrier(link))
            told.append(f"# ? ft_sensors: {link}, by its name; leave it out if no log has it. Signs: docs/study.md")
            yield {"name": link, "frame": link, "role": "cut", "sees": "payload_on_sensor"}
