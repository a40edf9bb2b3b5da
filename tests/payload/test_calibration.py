"""The sensor's own calibration: what nobody can see of it is in the doubt, what data show of it is taken out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.payload import foreign
from tests.payload.told import broken, evaluated, off, streamed

from exogauge.payload.evaluate import Evaluation
from exogauge.payload.live_start import open_start
from exogauge.payload.results import results

Array = NDArray[np.float64]


def state(folder: Path, said: str) -> None:
    file = folder / "payload.yaml"
    file.write_text(file.read_text(encoding="utf-8") + f"uncertainty: {said}\n", encoding="utf-8")


def test_a_gain_that_all_axes_share_is_a_doubt_of_the_same_share_of_the_body_and_of_no_zero(tmp_path: Path) -> None:
    """(1 + e) A Φ is A ((1 + e) Φ): no data tell one from the other."""
    foreign.write(tmp_path, 3, seconds=8.0, tests=False)
    state(tmp_path, "{ft_gain: 0, ft_gain_common: 0.02, ft_crosstalk: 0}")
    found = evaluated(tmp_path).stages
    assert found.excitation is not None
    assert found.exact is not None
    assert found.exact.excitation is not None
    exact, chosen = found.exact.excitation.chosen, found.excitation.chosen
    added = np.sqrt(np.diag(chosen.covariance - exact.covariance)[:10])
    assert added == pytest.approx(0.02 * np.abs(chosen.value[:10]), rel=0.02)
    assert chosen.std[10:] == pytest.approx(exact.std[10:], rel=0.01)
    told = np.sqrt(np.diag(found.compensation.covariance))
    assert told == pytest.approx(exact.std)  # what the sensor reads is foretold as well as ever


@pytest.mark.slow
def test_an_exact_sensor_adds_no_doubt_and_is_told_apart_from_one_of_which_nobody_says_anything(tmp_path: Path) -> None:
    foreign.write(tmp_path, 3, seconds=8.0, tests=False)
    usual = results(evaluated(tmp_path))
    state(tmp_path, "none")
    exact = results(evaluated(tmp_path))
    assert exact.calibration is None
    assert usual.calibration is not None
    assert usual.calibration.defaulted == ["ft_crosstalk", "ft_gain", "ft_gain_common"]
    assert usual.dynamic is not None
    assert exact.dynamic is not None
    mass, alone = usual.dynamic.values[0], exact.dynamic.values[0]
    assert 0.008 < mass.std / mass.value < 0.02 < 0.1
    assert alone.std / alone.value < 0.001
    assert usual.calibration.std_without["m"] == pytest.approx(alone.std, rel=0.3)


GAINS = 1.0 + np.array([0.022, -0.015, 0.012, -0.027, 0.018, 0.011])
ONE = np.eye(6)
ONE[0, 1] = 0.015
MIXED = np.diag(GAINS) + 0.008 * np.array(
    [[0, 1, -1, 0, 0, 0], [-1, 0, 1, 0, 0, 0], [1, 1, 0, 0, 0, 0], [0.07, 0, 0, 0, 1, 0], [0, -0.07, 0, 1, 0, -1],
     [0, 0.07, 0, -1, 1, 0]]
)  # fmt: skip
MATRICES = {"alike": 1.02 * np.eye(6), "one": ONE, "all": MIXED}


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., tuple[Path, foreign.Truth, Evaluation]]:
    """(which matrix, seed) -> folder, truth as it is read, what is told: made once."""

    @cache
    def made(name: str, seed: int) -> tuple[Path, foreign.Truth, Evaluation]:
        folder, matrix = tmp_path_factory.mktemp("sensor"), MATRICES[name]
        truth = foreign.write(folder, seed, spoil=foreign.wrench(lambda w: w @ matrix.T))
        return folder, replace(truth, zero=matrix @ truth.zero), evaluated(folder)

    return made


@pytest.mark.slow
def test_a_sensor_that_nobody_calibrated_misleads_nobody(made: Any) -> None:
    errors, live = [], []
    for seed, matrix in enumerate(MATRICES):
        folder, truth, found = made(matrix, seed)
        errors.append(off(found, truth))
        assert found.missing.decision.verdict in ("none", "effects")
        assert found.missing.in_the_model == (found.missing.decision.verdict == "effects")
        live.append(streamed(folder, truth)[0])
    assert not broken(errors, 4.0)
    assert not broken(live, 4.0)


@pytest.mark.slow
def test_gains_and_crosstalk_that_are_told_are_those_of_the_sensor_within_their_doubt(made: Any) -> None:
    """Of gains, how they differ: what they have in common is told with a doubt that holds it, as no log shows it."""
    z, common, taken_out, spread = list[Array](), list[float](), 0.0, 0.0
    for seed in (2,):
        told = results(made("all", seed)[2]).calibration
        assert told is not None
        assert told.taken_out is not None
        E, mean = MIXED - np.eye(6), float(np.diag(MIXED).mean()) - 1.0
        apart, true = np.array(told.taken_out) - told.common[0] * np.eye(6), E - mean * np.eye(6)
        z.append((apart - true) / np.array(told.std))
        common.append((told.common[0] - mean) / told.common[1])
        taken_out, spread = taken_out + np.sum((apart - true)[:3, :3] ** 2), spread + np.sum(true[:3, :3] ** 2)
        assert 0.008 < told.common[1] < 0.06
    assert np.mean(np.abs(z) < 1.96) > 0.85
    assert np.abs(z).max() < 4.0
    assert np.abs(common).max() < 3.0
    assert taken_out < 0.25 * spread


def cable(_name: str, table: Array) -> Array:
    """Pulls as the last joints turn, 0.1 m from the sensor."""
    pull = np.sin(table[:, [5]]) * [3.0, -4.0, 2.5] + (np.cos(table[:, [4]]) - 0.6) * [-2.0, 1.5, 3.0]
    wrench = np.hstack([pull, np.cross([0.03, -0.08, 0.1], pull)])
    return np.column_stack([table[:, :6], table[:, 6:] + wrench])


@pytest.mark.slow
def test_a_cable_is_no_unit_and_its_doubt_holds_and_live_says_that_it_cannot_be_believed(tmp_path: Path) -> None:
    """What nothing explains may be in the numbers as well as beside them: by what scatters they were 5 to 12 off."""
    truth = foreign.write(tmp_path, 2, spoil=cable, seconds=10.0)
    found = evaluated(tmp_path)
    assert found.missing.decision.verdict == "unexplained"
    assert np.abs(off(found, truth)).max() < 4.0
    _, start = open_start(tmp_path)
    assert start.in_doubt


def as_contact(folder: Path) -> None:
    file = folder / "payload.yaml"
    file.write_text(file.read_text(encoding="utf-8").replace("role: test", "role: contact"), encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("moving", [True, False])
def test_a_zero_that_moved_before_a_log_of_contact_is_no_contact_or_is_asked_for(moving: bool, tmp_path: Path) -> None:
    zero = np.array([2.5, -1.5, 2.0, 0.05, -0.04, 0.03])

    def spoil(name: str, table: Array) -> Array:
        share = {"still": 0.0, "shake": 0.5 if moving else 0.0, "other": 1.0}[name]
        return np.column_stack([table[:, :6], table[:, 6:] + share * zero])

    foreign.write(tmp_path, 4, spoil=spoil, seconds=10.0)
    as_contact(tmp_path)
    found = evaluated(tmp_path)
    told = [each for each in found.warnings if each.startswith("other: ")]
    assert len(told) == 1
    long = sum(touch.end - touch.start for touch in found.touches["other"])
    assert long < 1.0 if moving else long > 8.0
    assert ("taken for that" in told[0]) == moving
