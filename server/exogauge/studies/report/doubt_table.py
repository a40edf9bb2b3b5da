"""What the doubts of a few numbers are made of, as rows of a table."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

from exogauge.studies.words.doubt_words import source_advice, source_words
from exogauge.studies.words.rounding import significant


@final
@dataclass(frozen=True)
class DoubtRow:
    """One source of doubt: by number, standard deviation alone, and in per cent of the variance."""

    words: str
    cells: tuple[tuple[str, str], ...]
    advice: str


@final
@dataclass(frozen=True)
class DoubtTable:
    """heads: what each number is called, and smaller below it, of what and in which unit."""

    caption: str
    heads: tuple[tuple[str, str], ...]
    rows: tuple[DoubtRow, ...]


def doubt_table(caption: str, numbers: Mapping[tuple[str, str], Mapping[str, float]]) -> DoubtTable | None:
    """numbers: head -> source -> standard deviation; those without any are left out. None where none is left."""
    told = {head: parts for head, parts in numbers.items() if parts}
    return DoubtTable(caption, tuple(told), doubt_rows(list(told.values()))) if told else None


def doubt_rows(numbers: Sequence[Mapping[str, float]]) -> tuple[DoubtRow, ...]:
    """Sources in the order of their largest share in any number."""
    squares = [{source: std**2 for source, std in parts.items()} for parts in numbers]
    whole = [math.fsum(each.values()) for each in squares]
    largest: dict[str, float] = {}
    for each, total in zip(squares, whole, strict=True):
        for source, square in each.items():
            largest[source] = max(largest.get(source, 0.0), square / total if total > 0.0 else 0.0)
    rows = []
    for source in sorted(largest, key=lambda source: -largest[source]):
        cells = tuple(
            ("–", "")
            if source not in each
            else (significant(math.sqrt(each[source]), 2), _per_cent(each[source], total))
            for each, total in zip(squares, whole, strict=True)
        )
        rows.append(DoubtRow(source_words(source), cells, source_advice(source)))
    return tuple(rows)


def _per_cent(square: float, whole: float) -> str:
    share = 100.0 * square / whole if whole > 0.0 else 0.0
    return "< 1 %" if share < 1.0 else f"{share:.0f} %"
