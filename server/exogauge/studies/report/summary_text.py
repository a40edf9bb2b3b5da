"""The one-page report for a terminal, with the evidence of every effect that was named."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from exogauge.studies.report.page_model import Block
from exogauge.studies.report.summary_content import DETAILS, summary_content
from exogauge.studies.words.names import capital
from exogauge.terminal import text_table

WIDTH = 100
DETAIL = replace(DETAILS[0], files=4)  # the hashes of all stand in results.json


def summary_text(results: Mapping[str, Any]) -> str:
    """results: the content of results.json."""
    page = summary_content(results, DETAIL)
    blocks = [block for row in page.rows for block in row.blocks]
    findings = (results["discrepancy"] or {"findings": ()})["findings"]
    blocks[2:2] = [Block(capital(each["title"]), tuple(_story(each))) for each in findings]
    parts = ["\n".join(each for each in (page.label, page.title, page.kicker) if each)]
    parts += ["\n".join(_lines(block)) for block in blocks if block.title]
    return "\n\n".join([*parts, _filled(page.footer)])


def _story(finding: Mapping[str, Any]) -> Iterator[str]:
    yield finding["evidence"]
    if finding["motion"]:
        rivals = ", ".join(each["title"] for each in finding["also_possible"])
        files = ", ".join(each["file"] for each in finding["planned"])
        yield f"These data cannot tell it from {rivals}. {finding['motion']}{f' ({files})' if files else ''}"


def _lines(block: Block) -> Iterator[str]:
    yield block.title.upper()
    yield from (_filled(each) for each in block.sentences)
    if block.table is not None:
        yield text_table([each.title for each in block.table.columns], block.table.rows, widest=60)
        yield _filled(block.table.caption)
    yield from (_filled(f"{name}: {text}") for name, text in block.facts)
    yield from (_filled(each, "- ") for each in block.points)


def _filled(text: str, first: str = "") -> str:
    after = " " * len(first)
    return textwrap.fill(text, WIDTH, initial_indent=first, subsequent_indent=after, break_on_hyphens=False)
