"""DFKI double pendulum: two quasi-direct-drive joints, a swing of 6 s and a gentle run of 10 s at about 500 Hz."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest
from tests.real.recordings.double_pendulum import FILES, RECORDING, published, write

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def folder(recording: Callable[..., Path]) -> Path:
    folder = recording(RECORDING, FILES)
    write(folder)
    return folder


@pytest.fixture(scope="module")
def found(folder: Path, answer: Callable[..., Mapping[str, Any]]) -> Mapping[str, Any]:
    """The swing fitted, the gentle run held out."""
    return answer(folder / "swing.yaml")


def test_coulomb_friction_is_the_published_one_within_its_std(folder: Path, found: Mapping[str, Any]) -> None:
    p = published(folder)
    for joint, expected in zip(found["identification"]["joints"], (p["cf1"], p["cf2"]), strict=True):
        assert abs(joint["tau_c"]["value"] - expected) < joint["tau_c"]["std"]


def test_a_gap_without_a_name_stays_without_one(found: Mapping[str, Any]) -> None:
    assert found["discrepancy"]["verdict"] in ("unexplained", "none")
    assert found["discrepancy"]["findings"] == []


@pytest.fixture(scope="module")
def gentle(folder: Path) -> Path:
    """The gentle run fitted, no further."""
    text = (folder / "gentle.yaml").read_text()
    (folder / "gentle_fitted.yaml").write_text(text.replace("[identify, discrepancy]", "[identify]"))
    return folder / "gentle_fitted.yaml"


def test_the_gentle_run_can_be_fitted(gentle: Path, answer: Callable[..., Mapping[str, Any]]) -> None:
    assert 1.0 < answer(gentle)["identification"]["cutoff_hz"] < 100.0


def test_the_gentle_run_can_be_fitted_at_a_cut_off_that_is_given(
    gentle: Path, answer: Callable[..., Mapping[str, Any]]
) -> None:
    assert answer(gentle, cutoff_hz=8.0)["identification"]["cutoff_hz"] == 8.0
