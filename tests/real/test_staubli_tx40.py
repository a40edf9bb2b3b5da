"""Staubli TX40: a six-axis arm whose controller logs motor positions and torques at 5 kHz."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest

from exogauge.studies.evaluate import evaluate

pytestmark = pytest.mark.slow

JOINTS = tuple(f"joint_{k}" for k in range(1, 7))
GEARS = (32.0, 32.0, 45.0, -48.0, 45.0, 32.0)
OFFSETS = {"joint_2": "-pi/2", "joint_3": "pi/2"}
PUBLISHED_FV = np.array([8.05, 5.53, 1.97, 1.11, 1.86, 0.65])  # TX40_config.yaml
PUBLISHED_FS = np.array([7.14, 8.26, 6.34, 2.48, 3.03, 0.282])
PUBLISHED_OLS = np.array([6.64, 8.32, 4.28, 1.80, 2.65, 1.72])  # N·m on the same samples, mean 4.24

STUDY = """version: 1
name: Staubli TX40
robot: robot.yaml
logs:
  - {file: [pos_read_data.csv.gz, curr_data.csv.gz], mapping: mapping.yaml, role: identification,
     rows: [0, 24750], name: train}
  - {file: [pos_read_data.csv.gz, curr_data.csv.gz], mapping: mapping.yaml, role: validation,
     rows: [29250, 45000], name: held_out}
steps: [identify]
"""
ROBOT = """version: 1
urdf: tx40_mdh_modified.urdf
base: fixed
joints:
""" + "".join(
    f"  - {{name: {joint}, actuation: torque, gear_ratio: {gear}}}\n" for joint, gear in zip(JOINTS, GEARS, strict=True)
) + """transmission:
  joints: [joint_5, joint_6]
  matrix: [[45.0, 0.0], [32.0, 32.0]]
"""


def _mapping() -> str:
    text = "version: 1\nfiles:\n"
    for file, kind, unit in (("pos_read_data.csv.gz", "q", "rad"), ("curr_data.csv.gz", "tau", "N·m")):
        text += f"  - file: {file}\n    rate_hz: 5000\n    columns:\n"
        for joint in JOINTS:
            offset = f", offset: {OFFSETS[joint]}" if kind == "q" and joint in OFFSETS else ""
            text += f"      J{joint[1:]}: {{channel: {kind}.{joint}, unit: {unit}, side: motor{offset}}}\n"
    return text


@pytest.fixture(scope="module")
def results(recording: Callable[..., Path]) -> Path:
    """Result folder of the study with default settings."""
    folder = recording("staubli_tx40", ("pos_read_data.csv.gz", "curr_data.csv.gz", "tx40_mdh_modified.urdf"))
    (folder / "study.yaml").write_text(STUDY)
    (folder / "robot.yaml").write_text(ROBOT)
    (folder / "mapping.yaml").write_text(_mapping())
    evaluate(folder / "study.yaml", folder / "results", lambda _fraction, _phrase: None)
    return folder / "results"


def held_out_rmse(results: Path) -> np.ndarray:
    """(6,) [N·m] on 600 equally spaced held-out samples, against the torque as logged."""
    table = pq.read_table(results / "series" / "held_out.parquet")
    which = np.linspace(0, table.num_rows - 1, 600).astype(int)

    def column(name: str) -> np.ndarray:
        return table.column(name).to_numpy()[which]

    return np.array(
        [np.sqrt(np.mean((column(f"measured.tau.{j}") - column(f"predicted.tau.{j}")) ** 2)) for j in JOINTS]
    )


def identified(results: Path) -> Mapping[str, Any]:
    document: Mapping[str, Any] = json.loads((results / "results.json").read_text())["identification"]
    return document


def test_held_out_torques_are_predicted_far_better_than_published(results: Path) -> None:
    rmse = held_out_rmse(results)
    assert rmse.mean() < 2.4
    assert (rmse < PUBLISHED_OLS).all()


def test_friction_comes_out_near_the_published_values(results: Path) -> None:
    joints = identified(results)["joints"]
    k_d = np.array([joint["k_d"]["value"] for joint in joints])
    tau_c = np.array([joint["tau_c"]["value"] for joint in joints])
    print(k_d, tau_c)
    np.testing.assert_allclose(k_d, PUBLISHED_FV, rtol=0.5)
