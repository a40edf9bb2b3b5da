"""The report shows supporting torque and bands as the results say them, and says nothing where there is none."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from exogauge.devices.result import StiffnessResult
from exogauge.identification.result import Identification
from exogauge.remarks import About, Remark
from exogauge.studies.intake.open import open_study
from exogauge.studies.report.figures import draw_support, outline, runs
from exogauge.studies.report.stiffness_section import device_views, stiffness_sentence
from exogauge.studies.report.summary_figure import support_figure
from exogauge.studies.report.support_section import motion_views, strongest, support_sentence
from exogauge.studies.report.write import render_report
from exogauge.studies.results.document import Evaluation
from exogauge.studies.results.plain_values import finite
from exogauge.studies.results.support_results import support_entries
from exogauge.studies.words.rounding import between, significant
from exogauge.support.result import SupportResult

Render = Callable[..., str]


@pytest.fixture(scope="module")
def render(pristine: Path, identification: Identification) -> Render:
    """render(support, stiffness): the report of the small robot's study."""

    def made(support: SupportResult | None, stiffness: tuple[StiffnessResult, ...] = ()) -> str:
        with open_study(pristine) as study:
            return render_report(
                Evaluation(
                    study.name, study.robot, study.settings, study.steps, study.bundle.inputs, [], identification,
                    [], {}, support, stiffness,
                )
            )  # fmt: skip

    return made


@pytest.fixture(scope="module")
def report(render: Render, support: SupportResult, stiffness: tuple[StiffnessResult, ...]) -> str:
    return render(support, stiffness)


def words(html: str) -> str:
    return re.sub(r"\s+", " ", re.sub(r"<[^>]*>", " ", re.sub(r"<style>.*?</style>", "", html, flags=re.S)))


def test_the_first_sentence_is_the_main_result(support: SupportResult, stiffness: tuple[StiffnessResult, ...]) -> None:
    joint = strongest(support, "Normal suit")
    assert joint is not None
    peak = significant(abs(joint.by["a"].peak.value))
    assert support_sentence(joint) == (
        f"Normal suit (bend): up to {peak} ± 0.22 N·m of support at torso_pitch by approach A (band model 5.00)."
    )
    assert stiffness_sentence(stiffness, "Modified suit") == (
        "Stiffness of band group A 389.7 ± 2.9 N/m by approach A (truth 395.6)."
    )


@pytest.mark.slow
def test_the_report_opens_with_it_and_keeps_the_synthetic_label(report: str) -> None:
    header = words(report[report.index("<header>") : report.index("</header>")])
    assert header.index("Synthetic data") < header.index("Normal suit (bend): up to") < header.index("were identified")
    assert "evaluation of “Normal suit” and “Modified suit” on small" in header
    assert "truth 197.8 N/m, error −1.5 %" in header


@pytest.mark.slow
def test_every_number_of_the_captions_is_that_of_the_results(report: str, support: SupportResult) -> None:
    for view in motion_views(support):
        for row in view.errors:
            for value in (*row.rmse, *row.steady):
                assert value in words(report)
    first = support.joints[0].rmse
    assert f"RMSE A 0.300 · B 0.410 · paired {first['paired']:.3f} · maker’s values 2.00 N·m" in report


def test_one_figure_per_motion_with_a_panel_per_device(report: str) -> None:
    section = report[report.index('id="support"') : report.index('id="stiffness"')]
    assert section.count("<svg") == 2
    assert section.count("angle of torso_pitch") == 1
    assert section.count("angle of torso_yaw") == 1
    assert "log bend_normal_1 (Normal suit), bend_modified_1 (Modified suit)" in section
    for phase in ("lowering", "holding", "raising"):
        assert phase in section


def test_ids_stay_unique_and_nothing_is_asked_of_the_world(report: str) -> None:
    ids = re.findall(r'\bid="([^"]*)"', report)
    assert len(ids) == len(set(ids))
    assert not re.search(r"<script|<img|<link|url\((?!#)|(?:src|href)=\"(?!#)", report)
    assert report.count("<caption>") == len(re.findall(r"<table\b", report))
    assert set(re.findall(r'href="#([^"]*)"', report)) <= set(ids)


def test_without_a_device_there_are_no_such_sections(render: Render) -> None:
    html = render(None)
    assert 'id="support"' not in html
    assert 'id="stiffness"' not in html
    assert "identification of small" in html


@pytest.mark.slow
def test_without_reference_or_band_values_the_report_says_b_alone(render: Render, support: SupportResult) -> None:
    alone = dataclasses.replace(
        support,
        trials=tuple(
            dataclasses.replace(
                each,
                reference=None,
                support_a=None,
                support_a_std=None,
                low_a=None,
                high_a=None,
                band_model=None,
                equality=(),
                tension={},
            )
            for each in support.trials
        ),
        joints=tuple(
            dataclasses.replace(each, by={"b": each.by["b"]}, rmse={}, rmse_steady={}, null={}, spread={}, equality=())
            for each in support.joints
        ),
        band_model={},
    )
    text = words(render(alone))
    assert "N·m of support at torso_pitch by approach B." in text
    assert "no run without it" in text


def test_what_the_data_do_not_decide_is_marked_and_said(report: str, stiffness: tuple[StiffnessResult, ...]) -> None:
    view = device_views(stiffness)[0]
    assert [row.group for row in view.groups] == ["A", "B"]
    assert all(cell.kept for cell in view.groups[1].cells if cell is not None)
    assert sum(cell is not None for cell in view.groups[1].cells) == 3
    assert "B_left pulls nowhere in these motions" in report
    assert "stiffness[A] and natural_length[A_left] trade against each other (correlation 0.97)" in report
    assert "no bounds" in report


@pytest.mark.slow
def test_markup_in_names_stays_text(render: Render, support: SupportResult) -> None:
    odd = dataclasses.replace(
        support,
        trials=tuple(dataclasses.replace(each, device="<i>$x_1$&") for each in support.trials),
        joints=tuple(dataclasses.replace(each, device="<i>$x_1$&") for each in support.joints),
        band_model={"<i>$x_1$&": Remark(About.BANDS_IDENTIFIED, beside=("<b>bench</b>",))},
    )
    html = render(odd)
    assert "<i>$" not in html
    assert "<b>bench" not in html
    assert "&lt;i&gt;$x_1$&amp;" in html


def test_drawings_do_not_grow_with_the_log(support: SupportResult) -> None:
    trial = support.trials[0]
    long = {
        name: np.repeat(getattr(trial, name), 20, axis=0)
        for name in (
            "q", "support_a", "support_a_std", "support_b", "support_b_std", "support_prior", "band_model",
            "low_a", "high_a", "low_b", "high_b", "compared",
            "support_paired", "support_paired_std", "low_paired", "high_paired", "steady", "rest", "phase",
        )
    }  # fmt: skip
    longer = dataclasses.replace(trial, time=np.arange(20 * trial.time.size) / 200.0, **long)
    assert len(draw_support([longer], "torso_pitch", {}, "k")) < 100_000


def test_a_band_is_thinned_to_what_holds_all_of_it() -> None:
    time = np.arange(10_000.0)
    low, high = np.sin(time / 900.0) - 1.0, np.sin(time / 900.0) + 1.0
    high[4321] = 7.0
    low[4000:4200] = high[4000:4200] = np.nan
    at, below, above = outline(time, low, high, buckets=100)
    assert at.size == 100
    assert np.nanmax(above) == 7.0
    assert np.isnan(below[40:42]).all()
    assert np.isfinite(below[[39, 42]]).all()


def test_runs_are_stretches_of_one_value() -> None:
    assert list(runs(np.array([0, 0, 1, 1, 1, 0]))) == [(0, 2), (2, 5), (5, 6)]
    assert list(runs(np.array([False, True, True, False, True]))) == [(1, 3), (4, 5)]
    assert list(runs(np.array([], dtype=bool))) == []


@pytest.mark.parametrize(
    ("low", "high", "shown"),
    [
        (190.71, 200.93, "190.7 … 200.9"),
        (14.02, 1123.4, "14 … 1123"),
        (0.60352, 0.62114, "0.6035 … 0.6211"),
        (-0.2, 0.3, "−0.20 … 0.30"),
        (-np.inf, np.inf, "no bounds"),
    ],
)
def test_an_interval_has_the_digits_of_its_width(low: float, high: float, shown: str) -> None:
    assert between(low, high) == shown


def test_a_joint_that_slides_is_drawn_in_newtons_and_millimetres(support: SupportResult) -> None:
    trial = support.trials[0]
    joint = trial.joints[0]
    units = {**trial.prediction.units, f"tau.{joint}": "N"}
    slides = dataclasses.replace(trial, prediction=dataclasses.replace(trial.prediction, units=units))
    turns, slid = draw_support([trial], joint, {}, "a"), draw_support([slides], joint, {}, "b")
    assert ("[N·m]" in turns, "[°]" in turns, f"angle of {joint}" in turns) == (True, True, True)
    assert ("[N·m]" in slid, "[°]" in slid) == (False, False)
    assert ("[N]" in slid, "[mm]" in slid, f"position of {joint}" in slid) == (True, True, True)


def test_what_the_band_model_is_made_of_is_told_in_words(report: str) -> None:
    assert "which they are compared with: stiffness and natural length of the device file." in words(report)


def test_no_object_of_the_code_is_printed(report: str) -> None:
    assert not re.search(r"(?:&lt;|<)[A-Z]\w+\.\w+:|\b[A-Z][A-Za-z]+\((?:\w+=|\))", report)


@pytest.mark.slow
def test_what_the_doubt_of_peak_and_stiffness_is_made_of_stands_with_what_would_make_it_smaller(
    render: Render, support: SupportResult, stiffness: tuple[StiffnessResult, ...]
) -> None:
    parts = {"kt_drift": 0.4, "scatter": 0.3}
    joints = [
        dataclasses.replace(
            each,
            by={
                name: dataclasses.replace(effort, peak=dataclasses.replace(effort.peak, parts=parts))
                for name, effort in each.by.items()
            },
        )
        for each in support.joints
    ]
    bands = [
        dataclasses.replace(band, stiffness=dataclasses.replace(band.stiffness, parts={"via_points": 2.0}))
        for band in stiffness[0].bands
    ]
    doubted = (dataclasses.replace(stiffness[0], bands=tuple(bands)), *stiffness[1:])
    said = words(render(dataclasses.replace(support, joints=tuple(joints)), doubted))
    assert "What the doubts of peak and mean are made of" in said
    assert "torque per ampere, drifting from log to log 0.40 64 %" in said
    assert "scatter of the logs 0.30 36 %" in said
    assert "places of the via points 2.0 100 %" in said
    assert "Measure via points to 2 mm" in said


def test_no_peak_that_is_not_decided_is_told_or_drawn_as_if_it_was(
    support: SupportResult,
) -> None:
    undecided = support.with_nothing_decided({each.device for each in support.joints})
    joint = strongest(undecided, "Normal suit")
    assert joint is not None
    assert support_sentence(joint) == "Normal suit: what it gives is not decided."
    views = motion_views(undecided)
    assert [view.doubts for view in views] == [None] * len(views)
    for peak, _, _ in (row.cells for view in views for table in view.efforts for row in table.rows):
        assert all(each.startswith("(") and each.endswith(")") for each in peak[:3])
    entries = finite(support_entries(undecided))
    assert support_figure(entries, 20) is None
    assert support_figure(finite(support_entries(support)), 20) is not None
