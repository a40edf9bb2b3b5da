"""DFKI double pendulum: two quasi-direct-drive joints, a swing of 6 s and a gentle run of 10 s at about 500 Hz."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest
import yaml

pytestmark = pytest.mark.slow

GENTLE, SWING, PARAMETERS = "traj_143601.parquet", "traj_154220.parquet", "model_parameters.yml"
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


@pytest.fixture(scope="module")
def folder(recording: Callable[..., Path]) -> Path:
    folder = recording("dfki_double_pendulum", (GENTLE, SWING, PARAMETERS))
    (folder / "robot.urdf").write_text(urdf(published(folder)))
    (folder / "robot.yaml").write_text(ROBOT)
    (folder / "mapping.yaml").write_text(MAPPING)
    (folder / "swing.yaml").write_text(STUDY.format(fitted=SWING, held_out=GENTLE))
    (folder / "gentle.yaml").write_text(STUDY.format(fitted=GENTLE, held_out=SWING))
    return folder


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


@pytest.fixture(scope="module")
def found(folder: Path, answer: Callable[..., Mapping[str, Any]]) -> Mapping[str, Any]:
    """The swing fitted, the gentle run held out."""
    return answer(folder / "swing.yaml")


def test_coulomb_friction_is_the_published_one_within_its_std(folder: Path, found: Mapping[str, Any]) -> None:
    p = published(folder)
    for joint, expected in zip(found["identification"]["joints"], (p["cf1"], p["cf2"]), strict=True):
        assert abs(joint["tau_c"]["value"] - expected) < joint["tau_c"]["std"]


def test_a_gap_without_a_name_stays_without_one(found: Mapping[str, Any]) -> None:
    assert found["discrepancy"]["verdict"] in ("unexplained", "none")
    assert found["discrepancy"]["findings"] == []


def test_the_gentle_run_can_be_fitted(folder: Path, answer: Callable[..., Mapping[str, Any]]) -> None:
    assert 1.0 < answer(folder / "gentle.yaml")["identification"]["cutoff_hz"] < 100.0


def test_the_gentle_run_can_be_fitted_at_a_cut_off_that_is_given(
    folder: Path, answer: Callable[..., Mapping[str, Any]]
) -> None:
    assert answer(folder / "gentle.yaml", cutoff_hz=8.0)["identification"]["cutoff_hz"] == 8.0
