"""summary.html and summary.pdf: the whole evaluation on one sheet of A4, from one content.

summary.html: the one-page report for the screen and for printing on one sheet of A4; no outside requests.

Templates are those that lay beside this code when it was loaded: an installation that is upgraded beneath a running
job gives it none that asks for what its own code does not know.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from typing import Any, final

import jinja2

from exogauge.studies.report.page_model import Box, Drawing, Label, Line, Page
from exogauge.studies.report.summary_content import DETAILS, summary_content
from exogauge.studies.report.summary_pdf import Sheet, lay_out
from exogauge.studies.words.remark_words import sentence

SCALES = (1.0, 0.94, 0.88, 0.82)  # of the letters; smaller ones nobody reads


@final
@dataclass(frozen=True)
class SummaryPage:
    """content: what both say. fits: all of it is on the sheet."""

    html: bytes
    pdf: bytes
    content: Page
    fits: bool


def summary_page(results: Mapping[str, Any]) -> SummaryPage:
    """results: the content of results.json. First the letters get smaller, then less is told and the rest counted."""
    largest, *between, smallest = SCALES
    tried = list[Sheet]()

    def fits(scale: float) -> bool:
        tried.append(lay_out(content, scale))
        return tried[-1].fits

    for detail in DETAILS:
        content = summary_content(results, detail)
        if fits(largest):  # as most pages do
            break
        if fits(smallest):
            small = tried[-1]
            tried += [] if any(fits(scale) for scale in between) else [small]
            break
    chosen = tried[-1]
    page = SummaryPage(render_html(content, chosen.scale).encode(), chosen.bytes(), content, chosen.fits)
    for each in tried:
        each.put_away()
    return page


def render_html(page: Page, scale: float, kind: str = "one-page report") -> str:
    """scale: of the letters, 1 for 7.6 pt: that at which the page fits its sheet. kind: of document, for its title."""
    return TEMPLATES.get_template("summary.html.j2").render(page=page, scale=scale, marks=_marks, kind=kind)


def _marks(drawing: Drawing) -> list[tuple[str, Line | Box | Label]]:
    return [(type(mark).__name__.lower(), mark) for mark in drawing.marks]


_FOLDER = files("exogauge.studies") / "templates"

TEMPLATES = jinja2.Environment(
    loader=jinja2.DictLoader(
        {each.name: each.read_text(encoding="utf-8") for each in _FOLDER.iterdir() if each.name.endswith(".j2")}
    ),
    autoescape=True,
    undefined=jinja2.StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
)
TEMPLATES.filters["sentence"] = sentence
