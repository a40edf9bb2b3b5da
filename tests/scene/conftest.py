"""A robot with every kind of joint, seen from a base in its middle, and scenes read back as the player reads them."""

from __future__ import annotations

import gzip
import json
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from exogauge.robots.description import Joint, Robot, WrenchSensor
from exogauge.robots.tree import RigidTree
from exogauge.robots.urdf import load_tree

LINK = (
    '<link name="{0}"><inertial><origin xyz="0.01 0 {1}"/><mass value="{2}"/>'
    '<inertia ixx="0.02" ixy="0" ixz="0.001" iyy="0.03" iyz="0" izz="0.01"/></inertial></link>'
)
JOINT = (
    '<joint name="{0}" type="{1}"><parent link="{2}"/><child link="{3}"/><origin xyz="{4}" rpy="0.1 -0.2 0.3"/>'
    '<axis xyz="{5}"/><limit lower="-2" upper="2" effort="50" velocity="5"/></joint>'
)
URDF = (
    '<robot name="r">'
    + "".join(
        LINK.format(*each) for each in (("pelvis", 0.1, 4), ("chest", 0.2, 6), ("arm", -0.1, 2), ("leg", -0.2, 3))
    )
    + LINK.format("foot", -0.02, 1)
    + JOINT.format("waist", "revolute", "pelvis", "chest", "0 0 0.2", "0 1 0")
    + JOINT.format("shoulder", "revolute", "chest", "arm", "0 0.2 0.3", "1 0 0")
    + JOINT.format("hip", "revolute", "pelvis", "leg", "0 0.1 -0.1", "0 1 0")
    + JOINT.format("shin", "prismatic", "leg", "foot", "0 0 -0.4", "0 0 1")
    + "</robot>"
)
JOINTS = ("waist", "shoulder", "hip", "shin")


@pytest.fixture(scope="session")
def urdf() -> bytes:
    return URDF.encode()


@pytest.fixture(scope="session")
def make_robot(urdf: bytes) -> Callable[..., Robot]:
    """base_link, floating -> the robot, with a contact sensor at its foot."""

    def made(base_link: str = "chest", floating: bool = True) -> Robot:
        tree: RigidTree = load_tree(urdf, joints=JOINTS, base_link=base_link, floating=floating)
        return Robot(
            name="r",
            tree=tree,
            T_base_imu=None,
            axes_from_joints=np.eye(len(JOINTS)),
            joints=tuple(Joint(name, "torque") for name in JOINTS),
            sensors=(WrenchSensor("sole", "foot", "contact", 1.0),),
        )

    return made


class Scene:
    """header: as packed, arrays still to be looked up."""

    def __init__(self, packed: bytes) -> None:
        data = gzip.decompress(packed)
        length = int.from_bytes(data[:8], "little")
        self.header: dict[str, Any] = json.loads(data[8 : 8 + length])
        self._data, self._base = data, 8 + length

    def array(self, place: dict[str, Any]) -> NDArray[Any]:
        assert (self._base + place["offset"]) % 8 == 0
        return np.frombuffer(self._data, place["dtype"], place["length"], self._base + place["offset"])

    def track(self, kind: str, name: str) -> NDArray[Any]:
        """(F or 1, width)"""
        (found,) = (each for each in self.header["tracks"] if (each["kind"], each["name"]) == (kind, name))
        return self.array(found["values"]).reshape(-1, found["width"])

    def message(self, kind: str, name: str) -> dict[str, Any]:
        return [each for each in self.header["messages"] if each["type"] == kind and each.get("name") == name][-1]


@pytest.fixture(scope="session")
def unpack() -> Callable[[bytes], Scene]:
    return Scene
