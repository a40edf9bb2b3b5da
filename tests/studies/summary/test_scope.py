"""The scope sentence claims what was tested, and no more."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Callable
from typing import Any

from exogauge.studies.results.configuration import StudyRecord

Evaluated = Callable[..., dict[str, Any]]


def test_it_is_one_sentence_that_names_robot_wears_and_motions(whole: dict[str, Any]) -> None:
    sentence = whole["scope"]["sentence"]
    assert sentence.endswith(".")
    assert not re.search(r"[.!?] [A-Z]", sentence)
    for word in (whole["robot"], "Normal suit", "Modified suit", "bend", "twist"):
        assert word in sentence
    assert sentence.startswith("Synthetic data")


def test_ranges_and_speeds_are_those_reached_with_the_wear(whole: dict[str, Any]) -> None:
    (pitch,) = (
        joint
        for each in whole["scope"]["motions"]
        if (each["motion"], each["device"]) == ("bend", "Normal suit")
        for joint in each["joints"]
        if joint["joint"] == "torso_pitch"
    )
    assert (pitch["lowest"], pitch["highest"], pitch["top_speed"]) == (0.0, 1.2, 0.7)
    shown = f"torso_pitch 0.0 … {math.degrees(1.2):.1f}°, up to {math.degrees(0.7):.0f}°/s"
    assert shown in whole["scope"]["sentence"]


def test_a_joint_that_did_not_move_is_named_and_nothing_is_claimed_of_it(whole: dict[str, Any]) -> None:
    scope = whole["scope"]
    assert scope["not_moved"] == ["r_elbow"]
    assert any("Not moved" in each and "r_elbow" in each for each in scope["not_said"])
    assert "move 2 of 3 joints" in scope["sentence"] or "moves 2 of 3 joints" in scope["sentence"]


def test_what_goes_beyond_the_fitted_logs_is_said(whole: dict[str, Any]) -> None:
    """torso_pitch goes to 1.2 rad with the wear, to 0.8 in the fitted log; torso_yaw stays within."""
    (beyond,) = (each for each in whole["scope"]["not_said"] if "fitted logs" in each and "extrapolated" in each)
    assert "torso_pitch" in beyond
    assert "torso_yaw" not in beyond


def test_measured_data_are_not_called_synthetic(evaluated: Evaluated, record: StudyRecord) -> None:
    scope = evaluated(name="Lumbar wear", record=dataclasses.replace(record, synthetic=()))["scope"]
    assert not scope["synthetic"]
    assert "ynthetic" not in scope["sentence"] + " ".join(scope["not_said"])


def test_a_name_alone_keeps_the_label(evaluated: Evaluated, record: StudyRecord) -> None:
    assert evaluated(record=dataclasses.replace(record, synthetic=()))["scope"]["synthetic"]


def test_without_a_wear_nothing_is_said_of_one(evaluated: Evaluated, record: StudyRecord) -> None:
    bare = dataclasses.replace(record, wears=(), logs=record.logs[:2])
    scope = evaluated(support=None, stiffness=(), record=bare)["scope"]
    assert scope["motions"] == scope["devices"] == []
    assert "suit" not in scope["sentence"].lower()
    assert "1 fitted log that moves 2 of 3 joints" in scope["sentence"]
