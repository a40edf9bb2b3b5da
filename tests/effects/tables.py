"""The tables of docs/effects.md and docs/device.md, from the catalogue: `python -m tests.effects.tables` writes."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from exogauge.effects.band import BandEffect
from exogauge.effects.band_laws import LINEAR, SPRING
from exogauge.effects.catalogue import (
    all_effects,
    band_effects,
    base_effects,
    encoder_effects,
    link_effects,
    pair_effects,
    sensor_effects,
    shaped_effects,
    whole_sensor_effects,
)
from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Shape

DOCUMENT = Path(__file__).parents[2] / "docs" / "effects.md"
OF_DEVICES = DOCUMENT.with_name("device.md")
TABLE = re.compile(r"(<!-- table: (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)


def with_tables(text: str) -> str:
    """The document with every table between its marks made anew."""
    return TABLE.sub(lambda found: f"{found[1]}{tables()[found[2]]}{found[3]}", text)


def tables() -> Mapping[str, str]:
    """Place -> its table."""
    missing: dict[str, Mapping[str, Any]] = {
        "joint": shaped_effects(),
        "pair": pair_effects(),
        "encoder": encoder_effects(),
        "sensor": sensor_effects(),
        "whole_sensor": whole_sensor_effects(),
        "link": link_effects(),
        "base": base_effects(),
        "band": band_effects(),
    }
    made = {place: _missing(effects) for place, effects in missing.items()}
    has = [(f"`{each.name}`", each.sentence, _numbers([each.coefficient])) for each in all_effects().values()]
    return {"model": _table(("effect", "in words", "number"), has), "law": _laws()} | made


def _laws() -> str:
    """The laws of device.yaml: each value with its unit, and what it is where it is left out."""
    linear = (f"`{LINEAR}`", "", SPRING)
    rows = [(f"`{each.law}`", _values(each), each.sentence) for each in band_effects().values() if each.law]
    return _table(("`law`", "`law_values`", "the band"), [linear, *sorted(rows)])


def _values(effect: BandEffect) -> str:
    values: list[Quantity | Shape] = [*effect.coefficients, *effect.shapes]
    said, named = list[str](), {each.name: each for each in reversed(values)}
    for each in reversed(named.values()):
        stated, unit = effect.stated[each.name], "" if each.unit == "1" else f" [{each.unit}]"
        default = "" if stated.default is None else f" ({stated.default:g})"
        said.append(f"`{each.name}`{unit}{default} {each.words}")
    return "<br>".join(said)


def _missing(effects: Mapping[str, Any]) -> str:
    head = ("effect", "in words", "numbers", "the motion that shows it", "what can stand in for it")
    rows = [
        (f"`{name}`", each.sentence, _numbers([*each.coefficients, *each.shapes]), each.needs, _codes(each.confounds))
        for name, each in sorted(effects.items())
    ]
    return _table(head, rows)


def _numbers(quantities: Iterable[Any]) -> str:
    named = {each.name: each for each in reversed([*quantities])}  # a shape that is a coefficient's value is that one
    return "<br>".join(f"`{each.name}` {each.words}" for each in reversed(named.values()))


def _codes(names: Iterable[str]) -> str:
    return ", ".join(f"`{name}`" for name in names)


def _table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> str:
    lines = [head, ("---",) * len(head), *rows]
    return (
        "".join(f"| {' | '.join(cells)} |\n" for cells in lines).replace("| --- |", "|---|").replace(" --- |", "---|")
    )


if __name__ == "__main__":
    for document in (DOCUMENT, OF_DEVICES):
        document.write_text(with_tables(document.read_text(encoding="utf-8")), encoding="utf-8")
