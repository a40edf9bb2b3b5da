"""A one-joint study of a few kilobytes, which a worker evaluates in seconds."""

from __future__ import annotations

import io
import math
import zipfile
from collections.abc import Mapping

INERTIAL = (
    '<inertial><origin xyz="0 0 0.1"/><mass value="2.0"/>'
    '<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.01"/></inertial>'
)
URDF = f"""<robot name="arm">
  <link name="base">{INERTIAL}</link>
  <link name="arm">{INERTIAL}</link>
  <joint name="elbow" type="revolute"><parent link="base"/><child link="arm"/><origin xyz="0 0 0.2"/>
    <axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="50" velocity="5"/></joint>
</robot>
"""
ROBOT = """version: 1
name: One-joint arm
urdf: robot.urdf
base: fixed
base_link: base
joints:
  - {name: elbow, actuation: torque, gear_ratio: 50.0}
"""
STUDY = """version: 1
name: NAME
robot: robot.yaml
logs:
  - {file: logs/id.csv, role: identification}
  - {file: logs/val.csv, role: validation}
"""


def arm_study(name: str = "Arm on a bench") -> dict[str, bytes]:
    """path -> content."""
    texts = {"study.yaml": STUDY.replace("NAME", name), "robot.yaml": ROBOT, "robot.urdf": URDF}
    logs = {"logs/id.csv": swing(0.0), "logs/val.csv": swing(0.7)}
    return {path: text.encode() for path, text in (texts | logs).items()}


def swing(phase: float, samples: int = 2000) -> str:
    """A log of the elbow that swings at two frequencies, with gravity's torque and some friction."""
    rows = ["t,q.elbow,tau.elbow"]
    for k in range(samples):
        t = k / 100
        q = 0.8 * math.sin(2 * t + phase) + 0.3 * math.sin(5 * t)
        rate = 1.6 * math.cos(2 * t + phase) + 1.5 * math.cos(5 * t)
        acceleration = -3.2 * math.sin(2 * t + phase) - 7.5 * math.sin(5 * t)
        tau = 0.04 * acceleration - 1.96 * math.sin(q) + 0.2 * rate
        rows.append(f"{t:.3f},{q:.6f},{tau:.6f}")
    return "\n".join(rows) + "\n"


def zipped(files: Mapping[str, bytes]) -> bytes:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, content in files.items():
            archive.writestr(path, content)
    return packed.getvalue()
