from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
import yaml

from exogauge.errors import BadInput
from exogauge.synthetic import sensors, write_sample
from exogauge.synthetic.robot_facts import FEET, JOINT_NAMES
from exogauge.synthetic.study import LogPlan, write_study

ONE_SHORT_LOG = (LogPlan("id_1", "identification", "excitation", 7.0),)


def test_a_sample_is_a_whole_study_that_says_it_is_synthetic(folder: Path) -> None:
    study = yaml.safe_load((folder / "study.yaml").read_text(encoding="utf-8"))
    robot = yaml.safe_load((folder / study["robot"]).read_text(encoding="utf-8"))
    assert "SYNTHETIC" in study["name"]
    assert "SYNTHETIC" in (folder / "README.txt").read_text(encoding="utf-8")
    assert (folder / robot["urdf"]).is_file()
    for entry in study["logs"]:
        assert b"SYNTHETIC" in pq.read_schema(folder / entry["file"]).metadata[b"exogauge"]


def test_logs_hold_the_columns_of_the_contract(folder: Path) -> None:
    expected = ["t", *(f"q.{name}" for name in JOINT_NAMES), *(f"i.{name}" for name in JOINT_NAMES)]
    expected += [f"{kind}.{axis}" for kind in ("acc", "gyro") for axis in "xyz"]
    expected += [f"ft.{foot}.{part}" for foot in FEET for part in ("fx", "fy", "fz", "mx", "my", "mz")]
    table = pq.read_table(folder / "logs/id_1.parquet")
    assert table.column_names == expected
    assert table.num_rows == 12 * 200
    np.testing.assert_allclose(np.diff(table["t"].to_numpy()), 0.005, atol=1e-12)


def test_angles_are_counted_in_encoder_steps(folder: Path) -> None:
    angle = pq.read_table(folder / "logs/id_1.parquet")["q.torso_pitch"].to_numpy()
    counts = angle / sensors.ENCODER_STEP
    np.testing.assert_allclose(counts, np.round(counts), atol=1e-6)


@pytest.mark.parametrize("kind", ["i", "acc", "gyro", "force", "moment"])
def test_sensors_are_as_noisy_as_the_robot_file_says(kind: str) -> None:
    error = sensors.noisy(np.full(100_000, 0.3), kind, np.random.default_rng(0)) - 0.3
    assert error.std() == pytest.approx(sensors.NOISE[kind], rel=0.03)


def test_truth_names_every_body_and_joint(folder: Path) -> None:
    truth = json.loads((folder / "truth.json").read_text(encoding="utf-8"))
    assert set(truth) >= {"parameters", "joints", "bands", "effects"}
    assert len(truth["parameters"]) == 35 * 10 + 34 * 6
    assert truth["parameters"]["k_T[torso_pitch]"] == truth["joints"]["torso_pitch"]["k_T"]
    assert all(joint["tau_s"] >= joint["tau_c"] for joint in truth["joints"].values())


def test_the_same_seed_gives_the_same_bytes_and_another_seed_does_not(tmp_path: Path) -> None:
    for name, seed in (("a", 4), ("b", 4), ("c", 5)):
        write_study(tmp_path / name, seed, logs=ONE_SHORT_LOG)
    files = ["study.yaml", "robot.yaml", "robot.urdf", "truth.json", "logs/id_1.parquet"]
    a, b, c = ([(tmp_path / name / file).read_bytes() for file in files] for name in "abc")
    assert a == b
    assert a[3] != c[3]
    assert a[4] != c[4]
    assert a[1:3] == c[1:3], "what is told a priori does not depend on the seed"


def test_hiding_an_effect_changes_nothing_else_of_the_robot(tmp_path: Path, folder: Path) -> None:
    write_study(tmp_path, 3, hidden=["stribeck@torso_pitch"], logs=ONE_SHORT_LOG)
    hidden = json.loads((tmp_path / "truth.json").read_text(encoding="utf-8"))
    plain = json.loads((folder / "truth.json").read_text(encoding="utf-8"))
    assert hidden["parameters"] == plain["parameters"]
    assert [(e["effect"], e["where"]) for e in hidden["effects"]] == [("stribeck", {"joint": "torso_pitch"})]


def test_progress_only_rises_and_ends_at_one(tmp_path: Path) -> None:
    shares: list[float] = []
    write_study(tmp_path, 0, logs=ONE_SHORT_LOG, progress=lambda share, what: shares.append(share))
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


@pytest.mark.parametrize(
    ("arguments", "rule"),
    [
        ({"seed": 1, "suit": "normal"}, "unknown_suit"),
        ({"seed": -1}, "seed_negative"),
        ({"seed": 1, "hidden": ["gremlin@head"]}, "unknown_effect"),
    ],
)
def test_what_cannot_be_made_is_refused_before_anything_is_written(tmp_path: Path, arguments, rule: str) -> None:
    with pytest.raises(BadInput) as caught:
        write_sample(tmp_path / "out", **arguments)
    assert caught.value.faults[0].rule == rule
    assert not (tmp_path / "out").exists()
