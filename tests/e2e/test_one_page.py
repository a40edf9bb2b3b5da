"""The scope of an evaluation on its page, and the one-page report that it leads to."""

from __future__ import annotations

import copy
import io
import re
import unicodedata
from typing import TYPE_CHECKING, Any

import pytest
from playwright.sync_api import expect
from pypdf import PdfReader

from exogauge.studies.report.summary_page import summary_page

if TYPE_CHECKING:
    from playwright.sync_api import Page


def test_the_scope_stands_on_the_page_as_in_the_results(page: Page, study: dict[str, Any]) -> None:
    scope = study["results"]["scope"]
    page.goto(f"{study['path']}/scope")
    expect(page.locator("[data-scope]")).to_have_text(scope["sentence"])
    for each in scope["not_said"]:
        expect(page.get_by_role("listitem").filter(has_text=each)).to_be_visible()
    for wear in study["results"]["configuration"]["devices"]:
        expect(page.get_by_role("heading", name=wear["device"], exact=True)).to_be_visible()


def test_the_one_page_report_prints_on_one_sheet(page: Page, study: dict[str, Any]) -> None:
    page.goto(f"/api/v1/jobs/{study['job'].id}/artifacts/summary.html")
    (sheet,) = PdfReader(io.BytesIO(page.pdf(prefer_css_page_size=True))).pages
    said = bare(sheet.extract_text())
    assert bare(study["results"]["scope"]["sentence"]) in said
    assert "SYNTHETICDATA" in said


@pytest.mark.parametrize("width", [900, 1280])
def test_joints_with_long_names_stay_words(page: Page, study: dict[str, Any], width: int) -> None:
    """Names of a robot of another make: they broke into single letters, as numbers beside them do not break."""
    content = copy.deepcopy(study["results"])
    for each in content["support"]:
        each |= {"joint": "left_shoulder_pitch_joint", "device": "Back support of three layers"}
    page.set_viewport_size({"width": width, "height": 1200})
    page.set_content(summary_page(content).html.decode())
    for cell in page.locator("tbody th, tbody td:not(.number)").all():
        box, size = cell.bounding_box(), cell.evaluate("cell => parseFloat(getComputedStyle(cell).lineHeight)")
        assert box is not None
        assert box["height"] < 6.0 * size, cell.inner_text()
    for drawing in page.locator("svg").all():
        right = drawing.evaluate("svg => svg.getBoundingClientRect().right")
        ends = drawing.locator("text").evaluate_all("texts => texts.map(each => each.getBoundingClientRect().right)")
        assert max(ends) <= right + 1.0


def test_the_pdf_is_there_to_be_taken_away(page: Page, study: dict[str, Any]) -> None:
    page.goto(f"{study['path']}/scope")
    with page.expect_download() as found:
        page.get_by_role("link", name="The same as PDF").click()
    assert found.value.suggested_filename == "summary.pdf"
    (sheet,) = PdfReader(found.value.path()).pages
    assert "SYNTHETIC DATA" in sheet.extract_text()


def bare(text: str) -> str:
    """Without the breaks of lines, and without ligatures, which a PDF's letters may be drawn as."""
    return unicodedata.normalize("NFKC", re.sub(r"\s+", "", text))
