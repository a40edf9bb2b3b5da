"""The report tells of missing effects what the results say, draws it, and is silent where nobody looked."""

from __future__ import annotations

import dataclasses
import html as html_module
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from exogauge.devices.result import Estimate
from exogauge.effects.catalogue import shaped_effects
from exogauge.findings.result import Alternative, ChainStep, Consequence, Discrepancy, Evidence, Link, Place
from exogauge.findings.verdict import Caveat, Objection, Why
from exogauge.identification.result import Identification
from exogauge.studies.intake.open import open_study
from exogauge.studies.report.discrepancy_figures import draw_chain, draw_evidence, is_cut
from exogauge.studies.report.write import render_report
from exogauge.studies.results.document import Evaluation
from exogauge.studies.words.finding_sentences import finding_sentence
from exogauge.studies.words.reason_sentences import objection_words

Render = Callable[[Discrepancy | None], str]


@pytest.fixture(scope="module")
def render(pristine: Path, identification: Identification) -> Render:
    """The report of the small robot's study."""

    def made(found: Discrepancy | None) -> str:
        with open_study(pristine) as study:
            return render_report(
                Evaluation(
                    study.name, study.robot, study.settings, study.steps, study.bundle.inputs, [], identification,
                    [], {}, discrepancy=found,
                )
            )  # fmt: skip

    return made


@pytest.fixture(scope="module")
def report(render: Render, discrepancy: Discrepancy) -> str:
    return render(discrepancy)


def words(html: str) -> str:
    bare = re.sub(r"<[^>]*>", " ", re.sub(r"<style>.*?</style>", "", html, flags=re.S))
    return re.sub(r"\s+", " ", html_module.unescape(bare))


def section(html: str) -> str:
    found = re.search(r'<section class="gap".*?</section>', html, re.S)
    assert found is not None
    return found.group()


@pytest.mark.slow
def test_the_first_sentence_names_the_effect(report: str) -> None:
    header = words(report[report.index("<header>") : report.index("</header>")])
    assert header.index("does not know of 2 effects: Stribeck friction at torso_pitch") < header.index(
        "were identified"
    )


@pytest.mark.slow
def test_that_nothing_is_missing_is_said_after_the_rest(render: Render, clean: Discrepancy) -> None:
    bare = words(section(render(dataclasses.replace(clean, rejected=()))))
    assert "none of 214 candidates surely explains anything beyond noise" in bare
    text = words(section(render(clean)))
    assert "No effect that matters is missing as far as these logs can show. There, and smaller than what" in text
    assert "Looked at: 3 joint torques in steady motion on 1 held-out log; 214 candidates" in text
    assert "All of these torques stand at their noise floors." in text
    assert "left unexplained" not in text


def test_every_finding_stands_with_evidence_numbers_and_rivals(report: str, discrepancy: Discrepancy) -> None:
    html = section(report)
    text = words(html)
    for finding in discrepancy.findings:
        assert words(finding_sentence(finding)) in text
        for other in (*finding.alternatives, *finding.also_possible):
            assert words(objection_words(other.objection)) in text
    assert html.count("<article") == 2
    assert html.count("<svg") == 3  # the chain and two pieces of evidence
    assert "0.0413 ± 0.0062" in text
    assert f"The motion that would tell: {shaped_effects()['stribeck'].needs}" in text
    assert "Nothing among what was tried." in text  # the payload has no look-alike


@pytest.mark.slow
def test_a_device_that_it_hardly_changes_is_folded(render: Render, one: Discrepancy) -> None:
    same = Estimate(0.092, 0.0, "N·m")
    text = words(
        section(
            render(dataclasses.replace(one, before_after=(Consequence("rmse", ("suit", "bend", "l_hip"), same, same),)))
        )
    )
    assert "What it changes for the device Hardly changed: 1 quantity" in text
    assert "RMSE of approach B · suit, bend, l_hip 0.0920 0.0920 N·m 0 %" in text


def test_rivals_are_ordered_by_what_they_explain(report: str) -> None:
    table = section(report).partition("What it was tried against")[2]
    places = [
        table.index(f"<code>{name}</code>") for name in ("stribeck", "presliding", "nonlinear_viscous", "elasticity")
    ]
    assert places == sorted(places)


def test_what_is_left_what_changed_and_where_it_came_from(report: str) -> None:
    text = words(section(report))
    assert "torso_yaw 0.811 0.622 N·m 1.3 4.1 in a few moments: at 12 s of val_1" in text
    assert "RMSE of approach B · suit, bend, torso_pitch 1.83 ± 0.12 0.171 ± 0.020 N·m −91 %" in text
    assert "Judged and rejected: 3 " in text
    assert "m1-77c1 m0-3f2a Stribeck friction at torso_pitch" in text
    assert "m2-0b9e m1-77c1 Remainder of Stribeck friction at torso_pitch" in text
    assert "too little steady motion that was not fitted" in text


@pytest.mark.slow
def test_a_candidate_rejected_in_every_round_is_listed_once(render: Render, discrepancy: Discrepancy) -> None:
    again = tuple(dataclasses.replace(each, score=0.5 * each.score) for each in discrepancy.rejected)
    text = words(section(render(dataclasses.replace(discrepancy, rejected=again + discrepancy.rejected))))
    assert "Judged and rejected: 3 " in text
    assert "Torque ripple at every joint torque_ripple 6 %" in text


def test_a_gap_that_nothing_explains_names_its_places_once(render: Render, unexplained: Discrepancy) -> None:
    text = words(section(render(unexplained)))
    assert "Above the noise with the identified model" in text
    assert text.count("at a speed below 0.05 rad/s") == 1


def test_nothing_left_is_said_too(render: Render, one: Discrepancy) -> None:
    assert "With it in the model, all of these torques stand at their noise floors." in words(section(render(one)))


@pytest.mark.slow
def test_without_the_step_there_is_no_such_section(render: Render) -> None:
    html = render(None)
    assert 'id="discrepancy"' not in html
    assert "#discrepancy" not in html


def test_ids_stay_unique_captions_complete_and_nothing_is_asked_of_the_world(report: str) -> None:
    ids = re.findall(r'\bid="([^"]*)"', report)
    assert len(ids) == len(set(ids))
    assert not re.search(r"<script|<img|<link|url\((?!#)|(?:src|href)=\"(?!#)", report)
    assert report.count("<caption>") == len(re.findall(r"<table\b", report))
    assert set(re.findall(r'href="#([^"]*)"', report)) <= set(ids)
    numbers = [int(number) for number in re.findall(r"Figure (\d+)\.", report)]
    assert numbers == list(range(1, len(numbers) + 1))


def test_sections_come_in_the_order_that_the_head_of_the_page_names_them(report: str) -> None:
    named = re.findall(r'<li><a href="#([^"]*)"', report)
    assert len(named) >= 6
    assert named == sorted(named, key=lambda each: report.index(f'id="{each}"'))


def test_drawings_take_their_colours_from_the_page(report: str) -> None:
    drawn = "".join(re.findall(r"<svg.*?</svg>", section(report), re.S))
    assert not re.search(r"#[0-9a-f]{6}\b", drawn)
    assert {"var(--prior)", "var(--identified)", "var(--measured)", "var(--ink)"} <= set(
        re.findall(r"var\([^)]*\)", drawn)
    )


def test_markup_in_names_stays_text(render: Render, discrepancy: Discrepancy) -> None:
    odd = "<i>$x_1$&"
    finding = dataclasses.replace(
        discrepancy.findings[0],
        place=Place("joint", odd),
        alternatives=(Alternative(odd, discrepancy.findings[0].place, 0.1, Objection(Why.LESS)),),
    )
    html = render(
        dataclasses.replace(
            discrepancy,
            findings=(finding,),
            chain=tuple(
                dataclasses.replace(link, step=ChainStep("effect", odd, Place("joint", odd)), worst=odd)
                for link in discrepancy.chain
            ),
            notes=(Caveat("joined", odd),),
        )
    )
    assert "<i>$" not in html
    assert "&lt;i&gt;$x_1$&amp;" in html


def links(*sizes: float) -> list[Link]:
    return [
        Link(ChainStep("effect", f"model_{k}", Place("joint", "a")), size, 0.5, "tau.a", size, 0.5)
        for k, size in enumerate(sizes)
    ]


def test_only_a_first_bar_far_longer_than_the_next_is_cut() -> None:
    assert is_cut(links(9.0, 1.0))
    assert not is_cut(links(3.0, 1.0))
    assert not is_cut(links(9.0, 8.0))
    assert not is_cut(links(0.4))
    assert not is_cut(links(1.0, 2.0))


@pytest.mark.parametrize("sizes", [(9.0, 1.0), (1.0,), (0.4, 0.45), (float("nan"), 1.0), (0.0, 0.0)])
def test_every_chain_can_be_drawn(sizes: tuple[float, ...]) -> None:
    drawn = draw_chain(links(*sizes), "k")
    assert drawn.count("model ") == len(sizes)
    assert "noise floor" in drawn


def evidence(at: np.ndarray) -> Evidence:
    return Evidence("velocity", "rad/s", at, np.sin(at), 0.1 * np.sin(at), np.full(at.size, 0.05), np.sin(at))


@pytest.mark.parametrize(
    ("at", "stretched"),
    [
        (np.linspace(-1.0, 1.0, 30), False),
        (np.concatenate([-np.geomspace(1.0, 0.001, 15), np.geomspace(0.001, 1.0, 15)]), True),
        (np.array([0.0, 1e-9, 2e-9, 0.0, 0.0, 5.0]), True),
        (np.zeros(6), False),
        (np.array([0.3]), False),
        (np.full(8, np.nan), False),
        (np.array([]), False),
    ],
)
def test_an_axis_is_stretched_where_the_bins_crowd_about_zero(at: np.ndarray, stretched: bool) -> None:
    drawn = draw_evidence(evidence(at), {}, "k")
    assert ("stretched about zero" in drawn) == stretched
    assert "mathdefault" not in drawn
