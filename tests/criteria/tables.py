"""The tables of docs/criteria.md, from the criteria; `python -m tests.criteria.tables` (`make tables`) writes."""

from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path

from exogauge.criteria.criteria import Criteria
from exogauge.criteria.criterion import Criterion, listed

DOCUMENT = Path(__file__).parents[2] / "docs" / "criteria.md"
TABLES = re.compile(r"(<!-- tables -->\n).*?(<!-- end -->)", re.DOTALL)


def with_tables(text: str) -> str:
    """The document with its tables made anew."""
    return TABLES.sub(lambda found: f"{found[1]}{tables()}{found[2]}", text)


def tables() -> str:
    """One for each part of the criteria."""
    criteria = Criteria()
    return "\n".join(_table(part.name, [*listed(getattr(criteria, part.name))]) for part in fields(criteria)) + "\n"


def _table(part: str, of_part: list[Criterion]) -> str:
    head = f"## `{part}`\n\n| name | value | unit | why | source |\n|---|---|---|---|---|\n"
    return head + "".join(_row(each) for each in of_part)


def _row(each: Criterion) -> str:
    value = ", ".join(f"{one:g}" for one in each.value) if isinstance(each.value, tuple) else f"{each.value:g}"
    source = f"{each.source.kind}: {each.source.where}"
    return f"| `{each.name}` | {value} | {each.unit} | {each.why} | {source} |\n"


if __name__ == "__main__":
    DOCUMENT.write_text(with_tables(DOCUMENT.read_text(encoding="utf-8")), encoding="utf-8")
