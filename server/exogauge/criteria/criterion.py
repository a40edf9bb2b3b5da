"""A number that decides: its value stands in a field of a frozen
dataclass, its reason and its source beside it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, fields, is_dataclass
from typing import Any, Literal, TypeVar, final

Kind = Literal["derived", "measured", "convention", "judgement"]
Value = TypeVar("Value", bound=float | int | tuple[float, ...])

Z95 = 1.959964  # standard deviations on either side of a value that hold 95 % of a normal distribution


@final
@dataclass(frozen=True)
class Source:
    """kind: `derived` of an equation or a distribution; `measured` on recordings or cases; `convention` of the field;
    `judgement` of who made the rule, which nothing here measures alone. where: of what, or the document that holds it.
    """

    kind: Kind
    where: str


@final
@dataclass(frozen=True)
class Criterion:
    """One of them, as a reader sees it. name: `search.better`."""

    name: str
    value: float | int | tuple[float, ...]
    unit: str
    why: str
    source: Source


def criterion(value: Value, unit: str, why: str, source: Source) -> Value:
    """The default of a field. unit: `1` of a ratio or a count."""
    chosen: Value = field(default=value, metadata={"unit": unit, "why": why, "source": source})
    return chosen


def derived(of: str) -> Source:
    return Source("derived", of)


def measured(where: str) -> Source:
    return Source("measured", where)


def convention(whose: str) -> Source:
    return Source("convention", whose)


def judgement(where: str) -> Source:
    return Source("judgement", where)


def listed(criteria: Any, prefix: str = "") -> Iterator[Criterion]:
    """All of a dataclass of criteria, those of its parts behind the part's name."""
    for each in fields(criteria):
        value, name = getattr(criteria, each.name), f"{prefix}{each.name}"
        if is_dataclass(value):
            yield from listed(value, f"{name}.")
        else:
            yield Criterion(name, value, each.metadata["unit"], each.metadata["why"], each.metadata["source"])


def entries(criteria: Any, parts: Sequence[str] = ()) -> list[dict[str, Any]]:
    """As they stand in results.json. parts: those of the criteria that are told; none: all."""
    return [
        {
            "name": each.name,
            "value": list(each.value) if isinstance(each.value, tuple) else each.value,
            "unit": each.unit,
            "why": each.why,
            "source": each.source.kind,
            "where": each.source.where,
        }
        for each in listed(criteria)
        if not parts or each.name.partition(".")[0] in parts
    ]
