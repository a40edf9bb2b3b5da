"""Staubli TX40: a six-axis arm whose controller logs motor positions and torques at 5 kHz."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

RECORDING, FILES = "staubli_tx40", ("pos_read_data.csv.gz", "curr_data.csv.gz", "tx40_mdh_modified.urdf")
JOINTS = tuple(f"joint_{k}" for k in range(1, 7))
GEARS = (32.0, 32.0, 45.0, -48.0, 45.0, 32.0)
OFFSETS = {"joint_2": "-pi/2", "joint_3": "pi/2"}
TRAIN, HELD_OUT = slice(0, 24750), slice(29250, 45000)

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
ROBOT = (
    """version: 1
urdf: tx40_mdh_modified.urdf
base: fixed
joints:
"""
    + "".join(
        f"  - {{name: {joint}, actuation: torque, gear_ratio: {gear}}}\n"
        for joint, gear in zip(JOINTS, GEARS, strict=True)
    )
    + """transmission:
  joints: [joint_5, joint_6]
  matrix: [[45.0, 0.0], [32.0, 32.0]]
"""
)
OF_TABLES = """version: 1
name: {name}
robot: {robot}
logs:
  - {{file: train.parquet, role: identification}}
  - {{file: held_out.parquet, role: validation}}
"""
AT_A_GIVEN_CUTOFF = "settings: {cutoff_hz: 59.0, prior_strength: 1.0}\n"


def write(folder: Path) -> None:
    """study.yaml, and missing.yaml: with what may be missing."""
    (folder / "study.yaml").write_text(STUDY)
    (folder / "missing.yaml").write_text(STUDY.replace("steps: [identify]", "steps: [identify, discrepancy]"))
    (folder / "robot.yaml").write_text(ROBOT)
    (folder / "mapping.yaml").write_text(_mapping())


def write_uncoupled(folder: Path) -> None:
    """uncoupled.yaml: the same rows as joint angles and torques, and a robot.yaml without the coupled wrist."""
    _write_tables(folder, "tau")
    (folder / "robot_uncoupled.yaml").write_text(ROBOT.split("transmission:")[0])
    head = OF_TABLES.format(name="TX40, coupling withheld", robot="robot_uncoupled.yaml")
    (folder / "uncoupled.yaml").write_text(f"{head}steps: [identify, discrepancy]\n")


def write_as_currents(folder: Path, doubt: float) -> None:
    """currents.yaml: torques read as currents, each k_T stated as 1 N·m/A with that standard deviation."""
    _write_tables(folder, "i")
    joints = "".join(
        f"  - {{name: {j}, actuation: current, prior: {{k_T: 1.0}}, prior_std: {{k_T: {doubt}}}}}\n" for j in JOINTS
    )
    (folder / "robot.yaml").write_text(f"version: 1\nurdf: tx40_mdh_modified.urdf\nbase: fixed\njoints:\n{joints}")
    head = OF_TABLES.format(name="TX40 as currents", robot="robot.yaml")
    (folder / "currents.yaml").write_text(f"{head}{AT_A_GIVEN_CUTOFF}steps: [identify]\n")


def _mapping() -> str:
    text = "version: 1\nfiles:\n"
    for file, kind, unit in (("pos_read_data.csv.gz", "q", "rad"), ("curr_data.csv.gz", "tau", "N·m")):
        text += f"  - file: {file}\n    rate_hz: 5000\n    columns:\n"
        for joint in JOINTS:
            offset = f", offset: {OFFSETS[joint]}" if kind == "q" and joint in OFFSETS else ""
            text += f"      J{joint[1:]}: {{channel: {kind}.{joint}, unit: {unit}, side: motor{offset}}}\n"
    return text


def _write_tables(folder: Path, effort: str) -> None:
    """train.parquet and held_out.parquet: joint angles [rad] and joint torques [N·m] under the channels `effort`."""
    gears = np.diag(GEARS)
    gears[5, 4] = 32.0
    motor, torque = (
        np.loadtxt(folder / f"{name}.csv.gz", delimiter=",", skiprows=1) for name in ("pos_read_data", "curr_data")
    )
    q, tau = motor @ np.linalg.inv(gears).T + [0.0, -np.pi / 2, np.pi / 2, 0.0, 0.0, 0.0], torque @ gears
    for name, rows in (("train", TRAIN), ("held_out", HELD_OUT)):
        columns = {"t": np.arange(len(q[rows])) / 5000.0}
        columns |= {
            f"{kind}.{j}": values[rows, k] for kind, values in (("q", q), (effort, tau)) for k, j in enumerate(JOINTS)
        }
        pq.write_table(pa.table(columns), folder / f"{name}.parquet")
