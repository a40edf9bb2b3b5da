"""Staubli TX40 read as if its controller logged currents: the true torque constant of every joint is 1 N·m/A."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from exogauge.studies.evaluate import evaluate

pytestmark = pytest.mark.slow

JOINTS = tuple(f"joint_{k}" for k in range(1, 7))
DOUBTS = (0.02, 0.1, 0.3, 0.5)


@pytest.fixture(scope="module")
def found(recording: Callable[..., Path]) -> dict[float, tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Stated std -> k_T, its std, and held-out errors in N·m by the stated constants, which are amperes here."""
    folder = recording("staubli_tx40", ("pos_read_data.csv.gz", "curr_data.csv.gz", "tx40_mdh_modified.urdf"))
    gears = np.diag((32.0, 32.0, 45.0, -48.0, 45.0, 32.0))
    gears[5, 4] = 32.0
    motor, effort = (
        np.loadtxt(folder / f"{name}.csv.gz", delimiter=",", skiprows=1) for name in ("pos_read_data", "curr_data")
    )
    q, current = motor @ np.linalg.inv(gears).T + [0.0, -np.pi / 2, np.pi / 2, 0.0, 0.0, 0.0], effort @ gears
    for name, rows in (("train", slice(0, 24750)), ("held_out", slice(29250, 45000))):
        columns = {"t": np.arange(len(q[rows])) / 5000.0}
        columns |= {f"q.{j}": q[rows, k] for k, j in enumerate(JOINTS)}
        columns |= {f"i.{j}": current[rows, k] for k, j in enumerate(JOINTS)}
        pq.write_table(pa.table(columns), folder / f"{name}.parquet")
    (folder / "study.yaml").write_text(
        "version: 1\nname: TX40 as currents\nrobot: robot.yaml\nlogs:\n"
        "  - {file: train.parquet, role: identification}\n  - {file: held_out.parquet, role: validation}\n"
        "steps: [identify]\n"
    )
    results = {}
    for doubt in DOUBTS:
        joints = "".join(
            f"  - {{name: {j}, actuation: current, prior: {{k_T: 1.0}}, prior_std: {{k_T: {doubt}}}}}\n" for j in JOINTS
        )
        (folder / "robot.yaml").write_text(f"version: 1\nurdf: tx40_mdh_modified.urdf\nbase: fixed\njoints:\n{joints}")
        evaluate(folder / "study.yaml", folder / "out", lambda _f, _p: None, {"cutoff_hz": 59.0, "prior_strength": 1.0})
        told = json.loads((folder / "out/results.json").read_text())["identification"]
        errors = {each["channel"]: each["rmse_identified"] for each in told["validation"] if each["held_out"]}
        results[doubt] = (
            np.array([each["k_T"]["value"] for each in told["joints"]]),
            np.array([each["k_T"]["std"] for each in told["joints"]]),
            np.array([errors[f"tau.{j}"] for j in JOINTS]),
        )
    return results


@pytest.mark.parametrize("doubt", DOUBTS)
def test_every_torque_constant_is_one_within_its_doubt(
    found: dict[float, tuple[np.ndarray, ...]], doubt: float
) -> None:
    k_T, std, _ = found[doubt]
    assert np.all(np.abs(k_T - 1.0) < 2.0 * std)
    assert np.all(k_T > 0.7)


@pytest.mark.parametrize("doubt", DOUBTS[1:])
def test_the_error_does_not_fall_as_the_stated_doubt_grows(
    found: dict[float, tuple[np.ndarray, ...]], doubt: float
) -> None:
    np.testing.assert_allclose(found[doubt][2], found[DOUBTS[0]][2], rtol=0.05)
