"""A log that the doctor holds for spoiled: left out where another can be fitted; else nothing is said of its fit."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cache
from html import unescape
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.fuzz.small_robots import simulated_logs, write_study

from exogauge.studies.evaluate import evaluate

Columns = dict[str, np.ndarray]

pytestmark = pytest.mark.slow


@cache
def recorded(floating: bool = False) -> dict[str, Columns]:
    return simulated_logs(floating)


def turned(columns: Columns) -> Columns:
    return columns | {"i.j2": -columns["i.j2"]}


def dead(columns: Columns) -> Columns:
    return columns | {"q.j2": np.zeros_like(columns["q.j2"])}


def evaluated(place: Path, logs: dict[str, Columns], floating: bool = False) -> dict[str, Any]:
    study = write_study(place / "study", floating, logs, steps="[identify, discrepancy]")
    evaluate(study, place / "out", lambda *_: None)
    content: dict[str, Any] = json.loads((place / "out" / "results.json").read_text())
    content["page"] = unescape((place / "out" / "summary.html").read_text())
    content["report"] = unescape((place / "out" / "report.html").read_text())
    return content


@pytest.fixture(scope="module")
def right(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    return evaluated(tmp_path_factory.mktemp("right"), recorded())


@pytest.mark.parametrize(("spoil", "channel"), [(turned, "i.j2"), (dead, "q.j2")])
@pytest.mark.parametrize("name", ["id_1", "val_1"])
def test_one_of_several_is_neither_fitted_nor_judged_by(
    spoil: Callable[[Columns], Columns], channel: str, name: str, right: dict[str, Any], tmp_path: Path
) -> None:
    found = evaluated(tmp_path, recorded() | {name: spoil(recorded()[name])})
    (told,) = [each for each in found["notices"] if each["code"] == "logs_spoiled"]
    assert told["names"] == [name]
    assert told["sentence"].startswith(f"Left out, as the doctor holds it for spoiled: {name} ({channel} ")
    assert told["sentence"] in found["page"]
    assert not [each for each in found["notices"] if each["code"] == "doctor_errors"]  # nothing rests on it
    assert any(each["log"] == name for each in found["doctor"])
    assert name not in {each["log"] for each in found["identification"]["validation"]}
    assert found["discrepancy"]["findings"] == right["discrepancy"]["findings"] == []
    for then, now in zip(*(each["identification"]["joints"] for each in (right, found)), strict=True):
        for constant in ("k_T", "tau_c", "k_d"):
            size = abs(now[constant]["value"] - then[constant]["value"])
            assert size < 3.0 * float(np.hypot(now[constant]["std"], then[constant]["std"])), (then["joint"], constant)


def stopped(columns: Columns) -> Columns:
    """The plate tells nothing for a third of the log."""
    there = ~((columns["t"] > 5.0) & (columns["t"] < 12.0))
    return {name: values * there if name.startswith("ft.") else values for name, values in columns.items()}


def stopping(columns: Columns) -> Columns:
    """It stops every three seconds for half of that."""
    there = columns["t"] % 3.0 < 1.5
    return {name: values * there if name.startswith("ft.") else values for name, values in columns.items()}


def stuck(columns: Columns) -> Columns:
    """A current that repeats its last value for a twentieth of the log."""
    there = np.flatnonzero((columns["t"] > 5.0) & (columns["t"] < 6.0))
    current = columns["i.j2"].copy()
    current[there] = current[there[0]]
    return columns | {"i.j2": current}


def unmoved(columns: Columns) -> Columns:
    noise = np.random.default_rng(5).standard_normal((3, len(columns["t"])))
    return columns | {f"gyro.{axis}": 0.002 * each for axis, each in zip("xyz", noise, strict=True)}


def test_a_log_whose_gyro_tells_noise_alone_is_neither_fitted_nor_judged_by(tmp_path: Path) -> None:
    found = evaluated(tmp_path, recorded(True) | {"id_1": unmoved(recorded(True)["id_1"])}, True)
    (told,) = [each for each in found["notices"] if each["code"] == "logs_spoiled"]
    assert told["names"] == ["id_1"]
    assert "gyro tells no more than noise" in told["sentence"]
    assert found["discrepancy"]["findings"] == []


def behind(columns: Columns) -> Columns:
    """The IMU, by 150 ms."""
    late = {name: np.roll(each, 15) if name[:3] in ("acc", "gyr") else each for name, each in columns.items()}
    return {name: each[15:] for name, each in late.items()}


def test_logs_whose_imu_is_far_behind_are_not_unexplained(tmp_path: Path) -> None:
    found = evaluated(tmp_path, {name: behind(columns) for name, columns in recorded(True).items()}, True)
    (told,) = [each for each in found["notices"] if each["code"] == "spoiled_fit"]
    assert "acc and gyro come 150 ms late" in told["sentence"]
    assert found["discrepancy"]["verdict"] == "undecided"


def rippled(columns: Columns) -> Columns:
    """With an effect that the search names where no log is spoiled."""
    return columns | {"i.j3": columns["i.j3"] + 0.15 * np.sin(9.0 * columns["q.j3"])}


def exchanged(columns: Columns) -> Columns:
    return columns | {"i.j2": columns["i.j3"], "i.j3": columns["i.j2"]}


@pytest.mark.parametrize(
    ("floating", "spoil", "channel"),
    [
        (False, dead, "q.j2"),
        (True, dead, "q.j2"),
        (True, exchanged, "i.j3"),
        (True, stopping, "ft.plate"),
    ],
)
def test_where_no_other_is_fitted_nothing_is_named_and_no_number_counts_as_decided(
    floating: bool, spoil: Callable[[Columns], Columns], channel: str, tmp_path: Path
) -> None:
    """A dead position of the floating robot is contradicted in one fitted log alone; it is as dead in the other."""
    logs = {name: spoil(rippled(columns)) for name, columns in recorded(floating).items()}
    found = evaluated(tmp_path, logs, floating)
    told = [each for each in found["notices"] if each["code"] == "spoiled_fit"]
    assert [name for each in told for name in each["names"]] == ["id_1", "id_2"]
    for each in told:
        assert channel in each["sentence"]
        assert 0 <= found["page"].index(each["sentence"]) < found["page"].index("RMSE on")
        assert each["sentence"] in found["report"]
    assert found["discrepancy"]["verdict"] == "undecided"
    assert found["discrepancy"]["findings"] == []
    assert "urdf" not in found["files"]
    assert "the doctor holds id_1 for spoiled" in found["discrepancy"]["sentence"]
    parameters = found["identification"]["parameters"]
    assert parameters
    assert not [each["name"] for each in parameters if each["identifiable"]]
    assert {"k_T[j1]", "tau_c[j3]"} <= set(found["identification"]["unidentifiable"])


@pytest.mark.parametrize(
    ("floating", "stop", "channel", "out"),
    [(True, stopped, "ft.plate", (5.0, 12.0)), (False, stuck, "i.j2", (5.0, 6.0))],
)
def test_time_in_which_a_sensor_is_dead_is_left_out_and_the_rest_is_as_good_as_ever(
    floating: bool, stop: Callable[[Columns], Columns], channel: str, out: tuple[float, float], tmp_path: Path
) -> None:
    logs = {name: rippled(columns) for name, columns in recorded(floating).items()}
    whole = evaluated(tmp_path / "whole", logs, floating)
    found = evaluated(tmp_path / "dead", {name: stop(columns) for name, columns in logs.items()}, floating)
    assert not [each for each in found["notices"] if each["code"] in ("spoiled_fit", "logs_spoiled", "doctor_errors")]
    told = [each for each in found["doctor"] if each["rule"] == "cut_where_dead"]
    cut = {each["log"].rsplit("_", 2)[0] for each in told}
    assert cut >= {"id_1", "id_2"}, "one that moves the joint little meanwhile is whole"
    assert all(channel in each["detail"] and each["severity"] == "warning" for each in told)
    for entry in found["identification"]["validation"]:
        name, first, last = (entry["log"], 0, 1) if entry["log"] in logs else entry["log"].rsplit("_", 2)
        t = logs[name]["t"]
        assert t[int(last) - 1] <= out[0] + 0.02 or t[int(first)] >= out[1] - 0.02, entry["log"]
    names = [[(each["effect"], each["where"]) for each in one["discrepancy"]["findings"]] for one in (whole, found)]
    assert names[0] == names[1] != []
    for then, now in zip(*(each["identification"]["joints"] for each in (whole, found)), strict=True):
        for constant in ("k_T", "tau_c", "k_d"):
            size = abs(now[constant]["value"] - then[constant]["value"])
            assert size < 3.0 * float(np.hypot(now[constant]["std"], then[constant]["std"])), (then["joint"], constant)


def test_where_efforts_are_late_and_no_delay_is_in_the_model_nothing_counts_as_decided(tmp_path: Path) -> None:
    """Masses, friction and rotor inertia make up for the delay, each with a small doubt."""
    logs = {name: late(columns, 0.06) for name, columns in recorded().items()}
    study = write_study(tmp_path / "study", False, logs, steps="[identify]")
    evaluate(study, tmp_path / "out", lambda *_: None)
    found = json.loads((tmp_path / "out" / "results.json").read_text())
    assert {each["rule"] for each in found["doctor"] if each["severity"] == "warning"} == {"effort_delay"}
    (told,) = [each for each in found["notices"] if each["code"] == "late_fit"]
    assert "60 ms late" in told["sentence"]
    assert not any(each["identifiable"] for each in found["identification"]["parameters"])


def late(columns: Columns, seconds: float) -> Columns:
    t = columns["t"]
    currents = {name: np.interp(t - seconds, t, columns[name]) for name in columns if name.startswith("i.")}
    return columns | currents
