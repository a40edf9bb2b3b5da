"""Robots of `example_robot_data` without their meshes, as MuJoCo and a study take them."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.metadata import distribution
from pathlib import Path
from typing import final

FOLDER = "cmeel.prefix/share/example-robot-data/robots"
FINGERS = ("panda_finger_joint1", "panda_finger_joint2")


@final
@dataclass(frozen=True)
class StockRobot:
    """base_link: floating robots, the link that carries the IMU. feet: links at which it stands, sensors under them.

    held: joints that are made fixed. still: beginnings of the names of joints that do not move. posture: joint -> its
    mean angle [rad], half of its range where none is given.
    """

    name: str
    urdf: str
    base_link: str = ""
    feet: tuple[str, ...] = ()
    held: tuple[str, ...] = ()
    still: tuple[str, ...] = ()
    posture: Mapping[str, float] = field(default_factory=dict)

    def tree(self) -> ET.Element:
        """The URDF without what only shows or touches; gripper joints fixed; joints that mimic others too."""
        path = Path(str(distribution("example-robot-data").locate_file(f"{FOLDER}/{self.urdf}")))
        root = ET.fromstring(path.read_bytes())
        for link in root.iter("link"):
            for kind in ("visual", "collision"):
                for part in link.findall(kind):
                    link.remove(part)
        for joint in root.findall("joint"):
            if joint.get("name") in self.held or joint.find("mimic") is not None:
                joint.set("type", "fixed")
        for kind in ("transmission", "gazebo", "ros2_control", "material"):
            for part in root.findall(kind):
                root.remove(part)
        return root


UR5 = StockRobot("UR5", "ur_description/urdf/ur5_robot.urdf", posture={"shoulder_lift_joint": -1.2})
PANDA = StockRobot("Panda", "panda_description/urdf/panda.urdf", held=FINGERS)
TALOS = StockRobot(
    "Talos",
    "talos_data/robots/talos_reduced.urdf",
    base_link="base_link",
    feet=("left_sole_link", "right_sole_link"),
    still=("leg_", "gripper_"),
    posture={
        f"leg_{side}_{joint}": angle
        for side in ("left", "right")
        for joint, angle in (("3_joint", -0.4), ("4_joint", 0.8), ("5_joint", -0.4))
    },
)
ROBOTS = (UR5, PANDA, UR5, PANDA, TALOS)
"""In the order in which seeds take them."""
