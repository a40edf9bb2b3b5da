"""Staubli TX40 read as if its controller logged currents: the true torque constant of every joint is 1 N·m/A."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from tests.real.recordings.staubli_tx40 import FILES, JOINTS, RECORDING, write_as_currents

from exogauge.studies.evaluate import evaluate

pytestmark = pytest.mark.slow

DOUBTS = (0.02, 0.1, 0.5)


@pytest.fixture(scope="module")
def found(recording: Callable[..., Path]) -> dict[float, tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Stated std -> k_T, its std, and held-out errors in N·m by the stated constants, which are amperes here."""
    folder = recording(RECORDING, FILES)
    results = {}
    for doubt in DOUBTS:
        write_as_currents(folder, doubt)
        evaluate(folder / "currents.yaml", folder / "out", lambda *_: None)
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
