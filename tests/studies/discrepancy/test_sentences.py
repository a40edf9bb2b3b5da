"""The verdict in one sentence, on paper and in a terminal."""

from __future__ import annotations

import dataclasses
from typing import Any

import pytest

from exogauge.devices.result import Estimate
from exogauge.findings.result import Alternative, Discrepancy, Excess, Place
from exogauge.findings.verdict import Objection, Why
from exogauge.studies.results.discrepancy_results import discrepancy_entry
from exogauge.studies.results.plain_values import finite
from exogauge.studies.words.discrepancy_sentences import left_sentence, moves, verdict_sentence
from exogauge.studies.words.names import at_place, listed, place_words, titled, words_of_effects

CONTRACT = """
motor_gain viscous coulomb static_friction motor_offset stribeck load_coulomb asym_viscous nonlinear_viscous presliding
backlash elasticity joint_spring torque_ripple rotor_inertia kt_gain kt_saturation thermal_viscous
torque_offset_drift torque_delay friction_shift coupling payload link_mass contact base_tilt ft_gain ft_crosstalk
ft_drift imu_delay band_stiffness band_length band_viscous band_relaxation band_hardening band_slip band_via_friction
extra_band band_limited_log encoder_zero band_softening"""


def entry(found: Discrepancy) -> dict[str, Any]:
    made = finite(discrepancy_entry(found))
    assert isinstance(made, dict)
    return made


def test_one_effect_is_named_with_what_it_explains(one: Discrepancy) -> None:
    assert verdict_sentence(one) == (
        "The identified model does not know of Stribeck friction at torso_pitch. With it the error of torso_pitch on "
        "held-out logs falls from 2.25 to 1.08 N·m RMSE (noise floor 1.02)."
    )


def test_several_effects_are_named_in_their_order(discrepancy: Discrepancy) -> None:
    text = verdict_sentence(discrepancy)
    assert text.startswith(
        "The identified model does not know of 2 effects: Stribeck friction at torso_pitch (2.25 → 1.08 N·m"
    )
    assert "and a payload at r_arm (r_elbow: 1.31 → 0.644 N·m, noise floor 0.601)." in text


def test_of_many_effects_three_are_named_and_the_others_counted(discrepancy: Discrepancy) -> None:
    many = dataclasses.replace(discrepancy, findings=discrepancy.findings[:1] * 5)
    assert "does not know of 5 effects" in verdict_sentence(many)
    assert verdict_sentence(many).count("Stribeck") == 3
    assert " and 2 more." in verdict_sentence(many)


def test_a_named_effect_that_does_not_help_is_not_said_to(one: Discrepancy) -> None:
    held = dataclasses.replace(one.findings[0].held_out, rmse_after=2.4)
    worse = dataclasses.replace(one, findings=(dataclasses.replace(one.findings[0], held_out=held),))
    assert "rises from 2.25 to 2.40 N·m" in verdict_sentence(worse)


def test_nothing_missing_is_no_more_than_these_logs_can_show(clean: Discrepancy) -> None:
    assert verdict_sentence(dataclasses.replace(clean, rejected=())) == (
        "No effect is missing as far as these logs can show: none of 214 candidates surely explains anything "
        "beyond noise."
    )


def test_what_is_there_and_small_is_said_once_for_each_place(clean: Discrepancy) -> None:
    """`Nothing surely explains anything` was said of it."""
    small = Objection(Why.TOO_SMALL, 0.109, 0.263)
    at = Place("joint", "j1")
    rejected = [
        Alternative("nonlinear_viscous", at, 0.156, small),
        Alternative("stribeck", at, 0.159, small),
        Alternative("elasticity", Place("joint", "j2"), 0.3, Objection(Why.LITTLE, 0.0)),
    ]
    text = verdict_sentence(dataclasses.replace(clean, rejected=tuple(rejected)))
    assert text == (
        "No effect that matters is missing as far as these logs can show. There, and smaller than what matters: "
        f"{titled('stribeck', at)} (0.11 where the sensors' noise is 0.26)."
    )


def test_without_held_out_logs_nothing_is_claimed(clean: Discrepancy) -> None:
    found = dataclasses.replace(clean, seen=())
    assert found.verdict == "undecided"
    assert verdict_sentence(found) == (
        "Whether the model lacks an effect is undecided. Cannot judge: no log was held out."
    )


def test_too_little_motion_is_told_in_seconds(short: Discrepancy) -> None:
    text = verdict_sentence(short)
    assert "undecided" in text
    assert "1.2 of 5 s of steady held-out motion at torso_yaw" in text


def test_a_gap_that_nothing_explains_is_said_where_it_is_largest(unexplained: Discrepancy) -> None:
    text = verdict_sentence(unexplained)
    assert "most at torso_pitch (2.25 N·m RMSE, noise floor 1.02)" in text
    assert "none of 214 candidates explains it" in text


def test_what_stays_after_all_that_was_named_is_said(discrepancy: Discrepancy, one: Discrepancy) -> None:
    assert left_sentence(discrepancy) == (
        "One channel stays above the noise, at torso_yaw (0.811 N·m RMSE, noise floor 0.622)."
    )
    assert left_sentence(dataclasses.replace(one, rejected=())) == "Nothing is left above the noise."
    assert left_sentence(one).startswith("Nothing is left above the noise. There, and smaller than what matters: ")
    two = (*discrepancy.unexplained, Excess("tau.r_elbow", "N·m", 0.9, 0.6, float("nan")))
    assert left_sentence(dataclasses.replace(discrepancy, unexplained=two)).startswith(
        "2 channels stay above the noise, most at torso_yaw"
    )


def test_no_identifier_that_results_may_hold_is_lost_and_no_two_have_the_same_words() -> None:
    words = words_of_effects()
    assert words.keys() >= set(CONTRACT.split())
    assert len(set(words.values())) == len(words)


@pytest.mark.parametrize(
    ("kind", "name", "words"),
    [
        ("joint", "torso_pitch", "torso_pitch"),
        ("joint", "all", "every joint"),
        ("base", "base", "the base"),
        ("base", "", "the base"),
        ("band", "A_left", "band A_left"),
        ("sensor", "wrist", "sensor wrist"),
        ("log", "val_1", "log val_1"),
    ],
)
def test_a_place_says_what_it_is(kind: str, name: str, words: str) -> None:
    assert place_words(kind, name) == words


def test_an_effect_that_is_not_known_here_keeps_its_name() -> None:
    assert at_place("moon_phase", "joint", "wrist") == "moon phase at wrist"
    assert at_place("base_tilt", "base", "base") == "a tilted base"
    assert [listed(["a"]), listed(["a", "b"]), listed(["a", "b", "c"])] == ["a", "a and b", "a, b and c"]


@pytest.mark.parametrize(
    ("before", "after", "changed"),
    [
        ((200.0, 2.0), (200.1, 2.0), False),
        ((200.0, 2.0), (201.0, 2.0), True),
        ((200.0, 2.0), (200.0, 0.6), True),
        ((0.40, 0.0), (0.12, 0.0), True),
        ((0.40, 0.0), (0.41, 0.0), False),
        ((float("nan"), 0.0), (0.1, 0.0), True),
        ((90.0, float("inf")), (90.0, float("inf")), True),
        ((0.0, 0.0), (0.0, 0.0), False),
    ],
)
def test_a_quantity_is_unchanged_within_a_tenth_of_its_doubt(
    before: tuple[float, float], after: tuple[float, float], changed: bool
) -> None:
    assert moves(Estimate(*before, "N/m"), Estimate(*after, "N/m")) == changed
