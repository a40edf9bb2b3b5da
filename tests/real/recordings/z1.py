"""Unitree Z1: six joints follow a chirp under position control, 23.5 s at 200 Hz; no torque is measured."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from tests.real.recordings.placing import write_fixed_arm

RECORDING = "z1_pd_chirp"
LOG, GAINS = "z1_traj_0.parquet", "z1_gains.json"
FILES = (LOG, GAINS)
JOINTS = tuple(f"joint{k}" for k in range(1, 7))
HEAD = "version: 1\nname: Z1\nrobot: robot.yaml\nlogs:\n"
ENTRY = "  - {{file: log.parquet, rows: [{0}, {1}], role: {2}, name: part_{0}}}\n"
FIT, HOLD = "identification", "validation"
SPLITS = {
    "by_turns": ((0, 1400, FIT), (1400, 2300, HOLD), (2300, 3700, FIT), (3700, 4700, HOLD)),
    "slow_part": ((0, 2820, FIT), (2820, 4700, HOLD)),
}


def write(folder: Path) -> None:
    """by_turns.yaml and slow_part.yaml: parts of the chirp fitted in turn, or its slow part."""
    write_fixed_arm(folder, "z1_description/urdf/z1.urdf", JOINTS)
    pq.write_table(pa.table(commanded(folder)), folder / "log.parquet")
    for name, parts in SPLITS.items():
        logs = "".join(ENTRY.format(*part) for part in parts)
        (folder / f"{name}.yaml").write_text(f"{HEAD}{logs}steps: [identify, discrepancy]\n")


def logged(folder: Path, name: str) -> np.ndarray:
    return np.asarray(pq.read_table(folder / LOG).column(name).to_numpy(), dtype=float)


def commanded(folder: Path) -> dict[str, np.ndarray]:
    """t [s] and, per joint, q [rad] and the torque [N·m] that the control law asks for."""
    gains = json.loads((folder / GAINS).read_text())
    columns = {"t": logged(folder, "t_s")}
    for k, joint in enumerate(JOINTS):
        q, v = logged(folder, f"dof_pos_{joint}"), logged(folder, f"dof_vel_{joint}")
        columns[f"q.{joint}"] = q
        columns[f"tau.{joint}"] = gains["kp"][k] * (logged(folder, f"des_dof_pos_{joint}") - q) - gains["kd"][k] * v
    return columns
