"""The record says what was handed in: how far and fast joints went, which wear was on, what calls itself synthetic."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from exogauge.errors import BadStudy
from exogauge.identification.result import Identification
from exogauge.logs.model import Log
from exogauge.robots.description import Robot
from exogauge.studies.intake.contract import Conditions, DeviceRecord
from exogauge.studies.intake.open import open_study, read_recordings, read_worn
from exogauge.studies.results.configuration import (
    StudyRecord,
    configuration_entry,
    study_record,
    synthetic_signs,
    travels,
)

Rewrite = Callable[[str, str, str], Path]
RATE, AMPLITUDE, FREQUENCY, MIDDLE = 200.0, 0.5, 0.3, 0.1
NOISE = 1e-5
SUIT = """version: 1
name: {name}
record: {{model: SSL-2, serial: 42}}
bands:
  - name: back
    via_points: [{{link: chest_1, xyz: [-0.1, 0, 0.2]}}, {{link: BODY, xyz: [-0.12, 0, 0.1]}}]
    stiffness_n_per_m: 197.8
"""


@pytest.fixture(scope="module")
def robot(pristine: Path) -> Robot:
    with open_study(pristine) as study:
        return study.robot


@pytest.fixture(scope="module")
def log() -> Log:
    """One joint swings, one stands still under noise, one is a constant."""
    time = np.arange(0.0, 20.0, 1.0 / RATE)
    swing = MIDDLE + AMPLITUDE * np.sin(2.0 * np.pi * FREQUENCY * time)
    still = 0.3 + NOISE * np.random.default_rng(1).standard_normal(time.size)
    return Log("log", time, {"q.torso_yaw": swing, "q.torso_pitch": still, "q.r_elbow": np.full_like(time, -0.2)})


def test_a_swing_reaches_its_amplitude_at_its_own_speed(robot: Robot, log: Log) -> None:
    swing, *_ = travels(robot, log, 10.0, np.full(3, 0.01))
    assert swing.lowest == pytest.approx(MIDDLE - AMPLITUDE, abs=1e-4)
    assert swing.highest == pytest.approx(MIDDLE + AMPLITUDE, abs=1e-4)
    assert swing.top_speed == pytest.approx(2.0 * math.pi * FREQUENCY * AMPLITUDE, rel=1e-3)
    assert swing.moved


def test_noise_above_the_threshold_now_and_then_is_no_motion(robot: Robot, log: Log) -> None:
    _, still, constant = travels(robot, log, 10.0, np.full(3, 3.0 * 2.0 * math.pi * 6.0 * NOISE))
    assert not still.moved
    assert not constant.moved
    assert constant.top_speed == pytest.approx(0.0, abs=1e-9)


@pytest.fixture
def worn(folder: Path, rewrite: Rewrite) -> Path:
    """A study with one log each in two suits."""
    for name in ("one", "two"):
        (folder / "logs" / f"{name}.parquet").write_bytes((folder / "logs/id_1.parquet").read_bytes())
    for file, name in (("suit.yaml", "Suit"), ("thin.yaml", "Thin")):
        (folder / file).write_text(SUIT.format(name=name))
    logs = """  - {file: logs/one.parquet, role: with_device, motion: bend}
  - {file: logs/two.parquet, role: with_device, device: thin.yaml}
"""
    rewrite("study.yaml", "robot: robot.yaml\n", "robot: robot.yaml\ndevice: suit.yaml\n")
    return rewrite(
        "study.yaml", "settings:", f"{logs}conditions: {{recorded: 2026-03-01, temperature: 23 °C}}\nsettings:"
    )


def recorded(folder: Path, found: Identification) -> tuple[StudyRecord, dict]:
    with open_study(folder) as study:
        logs = [*(each.log for each in read_recordings(study)), *(each.log for each in read_worn(study))]
        record = study_record(study, logs, found)
        entry = configuration_entry(
            record, study.robot, study.settings, study.support_settings, found, study.bundle.inputs
        )
    return record, entry


@pytest.mark.slow
def test_every_log_says_what_was_worn(worn: Path, identification: Identification) -> None:
    record, entry = recorded(worn, identification)
    assert {each.log: each.device for each in record.logs} == {
        "id_1": None,
        "val_1": None,
        "one": "Suit",
        "two": "Thin",
    }
    assert {each["device"]: each["logs"] for each in entry["devices"]} == {"Suit": ["one"], "Thin": ["two"]}
    assert [each["motion"] for each in entry["logs"]] == [None, "bend", "bend", None]
    assert entry["logs"][0]["rate_hz"] == pytest.approx(200.0)


@pytest.mark.slow
def test_values_stand_as_stated_and_what_is_not_stated_is_null(worn: Path, identification: Identification) -> None:
    _, entry = recorded(worn, identification)
    (band,) = entry["devices"][0]["bands"]
    assert band["stiffness_n_per_m"] == 197.8
    assert band["natural_length_m"] is None
    assert [point["link"] for point in band["via_points"]] == ["chest_1", "BODY"]
    assert entry["devices"][0]["record"]["serial"] == "42"
    assert entry["devices"][0]["record"]["size"] is None
    assert entry["conditions"]["recorded"] == "2026-03-01"
    assert entry["conditions"]["temperature"] == "23 °C"
    assert entry["conditions"]["payload"] is None


def test_settings_are_those_used(folder: Path, rewrite: Rewrite, identification: Identification) -> None:
    rewrite("study.yaml", "{cutoff_hz: 10, prior_strength: 1}", "{motion_doubtful: 0.2}")
    _, entry = recorded(folder, identification)
    assert entry["settings"]["cutoff_hz"] == identification.cutoff_hz
    assert entry["settings"]["prior_strength"] == identification.prior_strength
    assert entry["settings"]["motion_doubtful"] == 0.2


def test_the_digest_of_the_inputs_is_that_of_sha256sums_list(folder: Path, identification: Identification) -> None:
    _, entry = recorded(folder, identification)
    files = ["logs/id_1.parquet", "logs/val_1.parquet", "robot.urdf", "robot.yaml", "study.yaml"]
    lines = [f"{hashlib.sha256((folder / file).read_bytes()).hexdigest()}  {file}\n" for file in files]
    assert entry["inputs_sha256"] == hashlib.sha256("".join(lines).encode()).hexdigest()


def test_data_stay_synthetic_also_under_another_name(folder: Path, rewrite: Rewrite) -> None:
    rewrite("study.yaml", "Small robot, synthetic", "Lumbar wear")
    signs = {"none": synthetic(folder)}
    table = pq.read_table(folder / "logs/val_1.parquet")
    marked = table.replace_schema_metadata({"exogauge": "SYNTHETIC: simulated"})
    pq.write_table(marked, folder / "logs/val_1.parquet")
    signs["log"] = synthetic(folder)
    (folder / "robot.yaml").write_text("# SYNTHETIC: measured on no robot\n" + (folder / "robot.yaml").read_text())
    signs["robot"] = synthetic(folder)
    rewrite("study.yaml", "Lumbar wear", "Synthetic lumbar wear")
    signs["name"] = synthetic(folder)
    assert signs == {
        "none": (),
        "log": ("logs/val_1.parquet",),
        "robot": ("robot.yaml", "logs/val_1.parquet"),
        "name": ("study.yaml", "robot.yaml", "logs/val_1.parquet"),
    }


def synthetic(folder: Path) -> tuple[str, ...]:
    with open_study(folder) as study:
        return synthetic_signs(study)


def test_an_unknown_key_of_a_record_is_refused_at_its_line(worn: Path, rewrite: Rewrite) -> None:
    rewrite("suit.yaml", "serial: 42", "seriel: 42")
    with pytest.raises(BadStudy) as caught:
        open_study(worn)
    (fault,) = caught.value.faults
    assert (fault.file, fault.row) == ("suit.yaml", 3)
    assert "serial" in fault.advice


def test_the_document_names_every_key_of_both_records() -> None:
    document = (Path(__file__).parents[3] / "docs" / "study.md").read_text(encoding="utf-8")
    for model in (Conditions, DeviceRecord):
        for key in model.model_fields:
            assert f"{key}:" in document, key
