"""summary.html: the one-page report for the screen and for printing on one sheet of A4; no outside requests."""

from __future__ import annotations

import jinja2

from exogauge.studies.report.page_model import Box, Drawing, Label, Line, Page

_ENVIRONMENT = jinja2.Environment(
    loader=jinja2.PackageLoader("exogauge.studies", "templates"),
    autoescape=True,
    undefined=jinja2.StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
)


def render_html(page: Page, scale: float, kind: str = "one-page report") -> str:
    """scale: of the letters, 1 for 7.6 pt: that at which the page fits its sheet. kind: of document, for its title."""
    return _ENVIRONMENT.get_template("summary.html.j2").render(page=page, scale=scale, marks=_marks, kind=kind)


def _marks(drawing: Drawing) -> list[tuple[str, Line | Box | Label]]:
    return [(type(mark).__name__.lower(), mark) for mark in drawing.marks]
