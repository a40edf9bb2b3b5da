"""Evaluations side by side: the matrix, the overlay, what is taken away, and a link that brings it back."""

from __future__ import annotations

import csv
import re
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from playwright.sync_api import expect
from tests.e2e.arm import arm_study, zipped
from tests.e2e.test_studies_page import drop

if TYPE_CHECKING:
    from playwright.sync_api import Page
    from tests.e2e.conftest import Service

SAMPLE = "Compare SYNTHETIC hrp4_like, seed 1, every step"


def choose_sample(page: Page) -> None:
    page.goto("/compare")
    page.get_by_label(SAMPLE).first.check()
    expect(page.get_by_role("heading", name="Supporting torque")).to_be_visible()


def results(page: Page) -> Any:
    found = re.search(r"jobs=([0-9a-f-]{36})", page.url)
    assert found
    return page.request.get(f"/api/v1/jobs/{found.group(1)}/results").json()


def test_nothing_finished_says_where_to_begin(page: Page, screenshot: Callable[[str], None]) -> None:
    page.goto("/compare")
    expect(page.get_by_role("heading", name="No evaluation has finished yet")).to_be_visible()
    screenshot("compare-empty")


def test_two_evaluations_differ_in_what_they_were_made_of(page: Page) -> None:
    for name in ("First arm", "Second arm"):
        files = arm_study(name)
        if name == "Second arm":
            files["logs/id.csv"] = files["logs/val.csv"]
        page.goto("/studies")
        page.get_by_role("button", name="Choose files").wait_for()
        drop(page, {"arm.zip": zipped(files)})
        page.wait_for_url(re.compile(r"/studies/[0-9a-f-]{36}$"))
    page.goto("/studies")
    for name in ("First arm", "Second arm"):
        row = page.get_by_role("listitem").filter(has_text=name)
        expect(row.get_by_text("Done")).to_be_visible(timeout=180_000)
    page.goto("/compare")
    page.get_by_label(re.compile("Compare First arm")).check()
    page.get_by_label(re.compile("Compare Second arm")).check()
    differing = page.get_by_role("region", name="What else differs: table").get_by_role("row")
    expect(differing.filter(has_text="file logs/id.csv")).to_be_visible()
    expect(differing.filter(has_text="file logs/val.csv")).to_have_count(0)
    expect(page.get_by_text("None of these evaluations had a device worn.")).to_be_visible()
    model = (
        page.get_by_role("region", name="The robot’s model: table")
        .get_by_role("row")
        .filter(has_text="Torque of all joints")
    )
    expect(model.get_by_role("cell")).to_have_count(2)


def test_the_matrix_shows_the_numbers_of_the_results(
    page: Page, sample_service: Service, screenshot: Callable[[str], None]
) -> None:
    choose_sample(page)
    row = (
        page.get_by_role("region", name="Supporting torque: table")
        .get_by_role("row")
        .filter(has_text="torso_pitch")
        .filter(has_text="Smart Suit Lite, normal")
    )
    said = float(row.get_by_role("cell").nth(2).inner_text().split("±")[0].replace("−", "-"))
    entry = next(
        each
        for each in results(page)["support"]
        if (each["device"], each["motion"], each["joint"]) == ("Smart Suit Lite, normal", "bend", "torso_pitch")
    )
    assert abs(said - entry["approaches"]["A"]["peak"]["value"]) < 0.06
    expect(page.get_by_label("Only differences")).to_be_disabled()  # one job differs from nothing
    expect(page.get_by_role("img", name=re.compile("Supporting torque on torso_pitch over bend"))).to_be_visible()
    screenshot("compare")


def test_a_link_brings_the_selection_back(page: Page, sample_service: Service) -> None:
    choose_sample(page)
    page.get_by_label("Shown").select_option("rmse")
    page.get_by_label("Every joint").check()
    page.get_by_label("Motion", exact=True).select_option("twist")
    page.goto(page.url)
    expect(page.get_by_label(SAMPLE).first).to_be_checked()
    expect(page.get_by_label("Shown")).to_have_value("rmse")
    expect(page.get_by_label("Every joint")).to_be_checked()
    expect(page.get_by_label("Motion", exact=True)).to_have_value("twist")


def test_tables_are_taken_away_as_csv_and_latex(page: Page, sample_service: Service) -> None:
    choose_sample(page)
    with page.expect_download() as download:
        page.get_by_role("link", name="supporting torque as CSV").click()
    rows = list(csv.DictReader(download.value.path().read_text(encoding="utf-8").splitlines()))
    assert len(rows) == sum(len(each["approaches"]) for each in results(page)["support"])
    with page.expect_download() as download:
        page.get_by_role("link", name="stiffness as LaTeX").click()
    assert r"\begin{tabular}" in download.value.path().read_text(encoding="utf-8")


def test_the_page_and_the_report_print_to_pdf(page: Page, sample_service: Service) -> None:
    page.emulate_media(color_scheme="dark")
    choose_sample(page)
    expect(page.get_by_role("img", name=re.compile("Supporting torque on"))).to_be_visible()
    printed = page.pdf(format="A4", landscape=True)
    assert printed.startswith(b"%PDF")
    expect(page.locator("html[data-mantine-color-scheme=dark]")).to_be_visible()  # as it was before it was printed
    with page.context.expect_page() as opened:
        page.get_by_role("link", name="Report of").click()
    report = opened.value
    report.wait_for_load_state()
    assert "Smart Suit Lite, normal" in report.inner_text("body")
    assert report.pdf(format="A4").startswith(b"%PDF")
