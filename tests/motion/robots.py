"""Folders of robots that motions are planned for: stock arms with their meshes, and the sample."""

from __future__ import annotations

import shutil
from importlib.metadata import distribution
from pathlib import Path
from xml.etree import ElementTree

import yaml

from exogauge.synthetic.urdf import robot_file, robot_urdf

STOCK = "cmeel.prefix/share/example-robot-data/robots"
ARMS = {  # urdf, joints, home [rad], acceleration [rad/s²] as the maker states it or, of UR10, as is usual
    "panda": ("panda_description/urdf/panda.urdf", [f"panda_joint{k}" for k in range(1, 8)],
              [0.0, -0.3, 0.0, -2.0, 0.0, 1.8, 0.7], [15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0]),
    "ur10": ("ur_description/urdf/ur10_robot.urdf",
             ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint", "wrist_1_joint", "wrist_2_joint",
              "wrist_3_joint"], [0.0, -1.6, 1.2, -1.2, -1.5, 0.0], [10.0] * 6),
}  # fmt: skip


def arm_folder(made: Path, name: str) -> Path:
    """robot.yaml of a stock robot with torques logged, its collision meshes beside it."""
    urdf, joints, home, fast = ARMS[name]
    made.mkdir(parents=True, exist_ok=True)
    file = Path(str(distribution("example-robot-data").locate_file(f"{STOCK}/{urdf}")))
    root = ElementTree.fromstring(file.read_bytes())
    (made / "robot.urdf").write_bytes(ElementTree.tostring(root))
    for mesh in {Path(each.get("filename", "")).name for each in root.findall(".//collision/geometry/mesh")}:
        for found in file.parents[1].rglob(mesh):
            if name in str(found.relative_to(file.parents[2])) and "collision" in str(found):
                shutil.copy(found, made / mesh)
    content = {
        "version": 1, "name": name, "urdf": "robot.urdf", "base": "fixed",
        "joints": [{"name": joint, "actuation": "torque"} for joint in joints],
        "noise": {"q": 1e-5, "tau": 0.1}, "uncertainty": "none", "inertial_prior_std": {"default": 0.1},
        "home": dict(zip(joints, home, strict=True)), "limits": {"acceleration": dict(zip(joints, fast, strict=True))},
    }  # fmt: skip
    (made / "robot.yaml").write_text(yaml.safe_dump(content))
    return made / "robot.yaml"


def sample_folder(made: Path) -> Path:
    """robot.yaml of the sample."""
    made.mkdir(parents=True, exist_ok=True)
    (made / "robot.urdf").write_text(robot_urdf())
    (made / "robot.yaml").write_text(yaml.safe_dump(dict(robot_file())))
    return made / "robot.yaml"
