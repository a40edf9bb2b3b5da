"""The truth that peaks and means are held against, and how far a told torque is off it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from tests.calibration.kinds import told
from tests.calibration.picture import calibration
from tests.calibration.torque import true_torque

TIME = np.arange(1400) / 200.0
OFF = 0.25  # [N·m] by which the told torque is off


@pytest.fixture
def found(tmp_path: Path) -> dict:
    """Two logs of a twist: one has its larger peak on the one side, the other on the other."""
    for name in ("study/truth", "series"):
        (tmp_path / name).mkdir(parents=True)
    for log, lower in (("one", 1.1), ("two", 0.95)):
        wave = np.sin(2.0 * np.pi * TIME / TIME[-1])
        line = np.where(wave > 0.0, 2.0 * wave, 2.0 * lower * wave)
        pq.write_table(pa.table({"t": TIME, "yaw": line}), tmp_path / "study/truth" / f"{log}.parquet")
        every = np.ones(len(TIME), dtype=bool)
        columns = {"support_b.yaw": line + OFF, "support_steady.yaw": every, "support_compared.yaw": every}
        pq.write_table(pa.table(columns), tmp_path / "series" / f"{log}.parquet")
    return true_torque(tmp_path / "study", tmp_path / "series", {"one": "twist", "two": "twist"})


def test_a_peak_is_of_one_side_in_all_logs(found: dict) -> None:
    assert found["true"]["twist"]["yaw"]["peak"] == pytest.approx(-2.0 * 1.025, rel=0.01)


def test_a_torque_that_is_off_by_a_constant_has_that_error(found: dict) -> None:
    assert found["rmse"]["twist"]["yaw"]["B"] == pytest.approx(OFF)
    assert "A" not in found["rmse"]["twist"]["yaw"]


def test_peaks_and_means_count_by_approach_and_as_the_headline(found: dict) -> None:
    number = {"value": -2.0, "std": 0.1}
    support = {"motion": "twist", "joint": "yaw", "peak": number, "mean": None,
               "approaches": {"B": {"peak": number, "mean": {"value": None, "std": None}}}}  # fmt: skip
    truth = {"joints": {}, "parameters": {}, "devices": {}, "torque": found}
    numbers = list(told({"identification": {"parameters": []}, "stiffness": [], "support": [support]}, truth))
    assert [each.kind for each in numbers] == ["peak, B", "peak, headline"]
    assert numbers[0].inside(0.95)
    assert not numbers[0].inside(0.05)
    assert calibration(numbers, "one sample").count("<polyline") == 2


def test_a_peak_of_the_other_side_is_held_against_the_larger_one(found: dict) -> None:
    for value, inside in ((2.05, True), (1.5, False)):
        support = {
            "motion": "twist",
            "joint": "yaw",
            "peak": {"value": value, "std": 0.1},
            "mean": None,
            "approaches": {},
        }
        truth = {"joints": {}, "parameters": {}, "devices": {}, "torque": found}
        (number,) = told({"identification": {"parameters": []}, "stiffness": [], "support": [support]}, truth)
        assert number.inside(0.95) == inside
