"""What the terminal says of a device is what results.json holds."""

from __future__ import annotations

import copy
import re

import pytest

from exogauge.devices.result import StiffnessResult
from exogauge.published import published
from exogauge.studies.results.document import finite
from exogauge.studies.results.stiffness_results import stiffness_entries
from exogauge.studies.results.support_results import support_entries
from exogauge.support.result import SupportResult
from exogauge.support_text import stiffness_text, support_text


@pytest.fixture(scope="module")
def result(support: SupportResult, stiffness: tuple[StiffnessResult, ...]) -> dict:
    return {"support": finite(support_entries(support)), "stiffness": finite(stiffness_entries(stiffness))}


def rows(text: str) -> list[list[str]]:
    """Cells are at least two spaces apart."""
    return [re.split(r" {2,}", line.strip()) for line in text.splitlines()]


def test_each_motion_and_device_has_a_row_at_its_main_joint(result: dict) -> None:
    found = rows(support_text(result))
    assert ["bend", "Normal suit", "torso_pitch", "0.300", "0.410", "2.00"] in [row[:6] for row in found]
    assert ["twist", "Modified suit", "torso_yaw", "0.300", "0.410", "2.00"] in [row[:6] for row in found]
    assert not any("r_elbow" in row for row in found)


def test_motions_that_are_not_alike_are_named(result: dict) -> None:
    assert "All motions that A compares are alike." in support_text(result)
    doubtful = copy.deepcopy(result)
    for each in doubtful["support"]:
        if (each["motion"], each["device"]) == ("bend", "Normal suit"):
            each["motion_equality"]["verdict"] = "doubtful"
    assert "not quite alike: bend with Normal suit at torso_pitch." in support_text(doubtful)


def test_tables_2_and_3_hold_truth_and_every_approach(result: dict) -> None:
    found = rows(stiffness_text(result))
    assert ["Normal suit", "A", "ground truth", "197.8"] in found
    assert ["Normal suit", "A", "approach A", "194.8", "2.9", "189.0 … 200.6", "−1.5"] in found
    assert ["Modified suit", "A", "maker's values", "237", "21", "195 … 279", "−40.0"] in found
    assert ["Normal suit", "B", "approach A", "90.00", "–", "not decided"] in found
    assert sum("approach A" in row for row in found) == 4  # per device and group, not per band


def test_a_study_without_a_device_says_nothing_of_one() -> None:
    assert support_text({"support": []}) == ""
    assert stiffness_text({}) == ""


def test_published_numbers_are_labelled_as_such() -> None:
    first = published().splitlines()[0]
    assert first.startswith("PUBLISHED")
    assert "not this sample" in first
