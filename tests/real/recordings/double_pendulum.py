"""DFKI double pendulum: two quasi-direct-drive joints, a swing of 6 s and a gentle run of 10 s at about 500 Hz."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import yaml

RECORDING = "dfki_double_pendulum"
GENTLE, SWING, PARAMETERS = "traj_143601.parquet", "traj_154220.parquet", "model_parameters.yml"
FILES = (GENTLE, SWING, PARAMETERS)
JOINTS = ("shoulder", "elbow")
LINK = """<link name="{name}"><inertial><origin xyz="0 0 {z}"/><mass value="{mass}"/>
<inertia ixx="{I}" iyy="{I}" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>
"""
JOINT = """<joint name="{name}" type="continuous"><parent link="{parent}"/><child link="{child}"/>
<origin xyz="0 0 {z}"/><axis xyz="0 1 0"/></joint>
"""
ROBOT = "version: 1\nurdf: robot.urdf\nbase: fixed\njoints:\n" + "".join(
    f"  - {{name: {joint}, actuation: torque}}\n" for joint in JOINTS
)
MAPPING = """version: 1
rate_hz: 500
files:
  - file: "traj_*.parquet"
    time: {column: time, unit: s}
    columns:
      pos_meas1: {channel: q.shoulder, unit: rad}
      pos_meas2: {channel: q.elbow, unit: rad}
      tau_meas1: {channel: tau.shoulder, unit: N·m}
      tau_meas2: {channel: tau.elbow, unit: N·m}
    ignore: rest
"""
STUDY = """version: 1
name: Double pendulum
robot: robot.yaml
logs:
  - {{file: {fitted}, mapping: mapping.yaml, role: identification}}
  - {{file: {held_out}, mapping: mapping.yaml, role: validation}}
steps: [identify, discrepancy]
"""


def write(folder: Path) -> None:
    """swing.yaml and gentle.yaml: which of both runs is fitted; the other is held out."""
    (folder / "robot.urdf").write_text(urdf(published(folder)))
    (folder / "robot.yaml").write_text(ROBOT)
    (folder / "mapping.yaml").write_text(MAPPING)
    (folder / "swing.yaml").write_text(STUDY.format(fitted=SWING, held_out=GENTLE))
    (folder / "gentle.yaml").write_text(STUDY.format(fitted=GENTLE, held_out=SWING))


def published(folder: Path) -> Mapping[str, float]:
    values: Mapping[str, float] = yaml.safe_load((folder / PARAMETERS).read_text())
    return values


def urdf(p: Mapping[str, float]) -> str:
    """Hanging along -z at zero. The published inertias are about the joints, a URDF's about the centres of mass."""
    links = [
        LINK.format(name=name, z=-p[f"r{k}"], mass=p[f"m{k}"], I=p[f"I{k}"] - p[f"m{k}"] * p[f"r{k}"] ** 2)
        for k, name in ((1, "upper"), (2, "lower"))
    ]
    joints = [
        JOINT.format(name="shoulder", parent="base", child="upper", z=0),
        JOINT.format(name="elbow", parent="upper", child="lower", z=-p["l1"]),
    ]
    return "".join(['<robot name="double_pendulum"><link name="base"/>', *links, *joints, "</robot>"])
