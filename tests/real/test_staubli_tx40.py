"""Staubli TX40: a six-axis arm whose controller logs motor positions and torques at 5 kHz."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from tests.real.recordings.staubli_tx40 import FILES, JOINTS, RECORDING, write, write_uncoupled

from exogauge.identification.settings import Settings
from exogauge.studies.evaluate import evaluate

pytestmark = pytest.mark.slow

# TX40_config.yaml. Joint 6's Coulomb friction: fs + fsm6, since both act where its motor turns.
PUBLISHED_VISCOUS = np.array([8.05, 5.53, 1.97, 1.11, 1.86, 0.65])
PUBLISHED_COULOMB = np.array([7.14, 8.26, 6.34, 2.48, 3.03, 0.282 + 1.95])
PUBLISHED_OLS = np.array([6.64, 8.32, 4.28, 1.80, 2.65, 1.72])  # N·m on the same samples, mean 4.24


@pytest.fixture(scope="module")
def folder(recording: Callable[..., Path]) -> Path:
    folder = recording(RECORDING, FILES)
    write(folder)
    write_uncoupled(folder)
    return folder


@pytest.fixture(scope="module")
def results(folder: Path, answer: Callable[..., Mapping[str, Any]]) -> Path:
    """Result folder of the study with default settings; nothing is named in it, so it predicts as identified."""
    assert answer(folder / "missing.yaml")["discrepancy"]["findings"] == []
    return folder / "results_missing"


def held_out_rmse(results: Path) -> np.ndarray:
    """(6,) [N·m] on 600 equally spaced held-out samples, against the torque as logged."""
    table = pq.read_table(results / "series" / "held_out.parquet")
    assert table.num_rows == 15_750
    which = np.linspace(0, table.num_rows - 1, 600).astype(int)

    def column(name: str) -> np.ndarray:
        return np.asarray(table.column(name).to_numpy()[which])

    return np.array(
        [np.sqrt(np.mean((column(f"measured.tau.{j}") - column(f"predicted.tau.{j}")) ** 2)) for j in JOINTS]
    )


def values(results: Path, name: str) -> np.ndarray:
    """(6,) one identified parameter of every joint."""
    document = json.loads((results / "results.json").read_text())
    return np.array([joint[name]["value"] for joint in document["identification"]["joints"]])


def test_held_out_torques_are_predicted_better_than_published(results: Path) -> None:
    rmse = held_out_rmse(results)
    assert rmse.mean() < 2.4
    assert (rmse < PUBLISHED_OLS).all()


def test_friction_comes_out_near_the_published_values(results: Path) -> None:
    np.testing.assert_allclose(values(results, "k_d"), PUBLISHED_VISCOUS, rtol=0.4)
    np.testing.assert_allclose(values(results, "tau_c"), PUBLISHED_COULOMB, rtol=0.4)


def test_most_of_the_gain_stays_when_the_prediction_does_not_know_the_sign_at_rest(folder: Path) -> None:
    effects = [name for name in Settings().effects if name != "static_friction"]
    evaluate(folder, folder / "signless", lambda *_: None, {"effects": effects})
    assert held_out_rmse(folder / "signless").mean() < 2.6


@pytest.fixture(scope="module")
def discrepancy(folder: Path, answer: Callable[..., Mapping[str, Any]]) -> Mapping[str, Any]:
    found: Mapping[str, Any] = answer(folder / "missing.yaml")["discrepancy"]
    return found


def test_nothing_is_named_on_three_seconds_half_of_which_stand_still(discrepancy: Mapping[str, Any]) -> None:
    assert discrepancy["verdict"] == "unexplained"
    assert discrepancy["findings"] == []
    assert discrepancy["rejected"]
    for each in discrepancy["rejected"]:
        assert each["objection"]["why"] == "too_short"


def test_the_gap_that_is_left_is_shown(discrepancy: Mapping[str, Any]) -> None:
    left = {each["channel"]: each for each in discrepancy["unexplained"]}
    assert {"tau.joint_2", "tau.joint_3"} <= set(left)
    assert all(each["rmse"] > 2.0 * each["noise_floor"] for each in left.values())


def test_stribeck_which_is_not_in_this_recording_is_not_even_a_candidate_worth_judging(
    discrepancy: Mapping[str, Any],
) -> None:
    assert "stribeck" not in {each["effect"] for each in discrepancy["rejected"]}


@pytest.fixture(scope="module")
def uncoupled(folder: Path, answer: Callable[..., Mapping[str, Any]]) -> Mapping[str, Any]:
    """The same rows as joint angles and joint torques, and a robot.yaml that does not know of the coupled wrist."""
    found: Mapping[str, Any] = answer(folder / "uncoupled.yaml")["discrepancy"]
    return found


def test_a_wrist_whose_coupling_is_withheld_is_seen_but_cannot_be_judged_on_this_split(
    uncoupled: Mapping[str, Any],
) -> None:
    tried = {(each["effect"], each["where"]["joint"]): each for each in uncoupled["rejected"]}
    wrist = tried["coupling", "joint_6"]
    assert wrist["score"] > 0.8
    assert wrist["score"] == max(each["score"] for each in tried.values())
    assert wrist["objection"]["why"] == "too_short"
    above = {each["channel"]: each["rmse"] for each in uncoupled["unexplained"]}
    assert above["tau.joint_5"] > 5.0


def test_a_wrist_whose_coupling_is_stated_is_not_coupled_once_more(discrepancy: Mapping[str, Any]) -> None:
    again = [each for each in discrepancy["rejected"] if each["effect"] == "coupling"]
    assert all(each["score"] < 0.5 for each in again)
