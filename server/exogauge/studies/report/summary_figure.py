"""The one-page report's drawing: peak supporting torque by A, by B and by the band model, each with two deviations."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from exogauge.studies.report.page_model import Box, Drawing, Label, Line, plain
from exogauge.studies.words.rounding import significant

WIDTH, TOP, PITCH, FOOT = 63.0, 6.0, 6.6, 8.0  # [mm]
LEFT, RIGHT = 29.0, 1.0  # room for names, and at the end of the axis
LEGEND = 18.0  # [mm] its left end: `band model` is 12 mm long
SMALL = 2.1  # size of letters
DEVIATIONS = 2.0
TICKS = 4
Mark = Line | Box | Label


def support_figure(chosen: Sequence[Mapping[str, Any]], name: int) -> Drawing | None:
    """chosen: of `support`, one line each; None where there is nothing to draw."""
    entries = [each for each in chosen if _shown(each)]
    if not entries:
        return None
    ends = [end for each in entries for approach in each["approaches"] for end in _span(each, approach)]
    low, high = min(0.0, *ends), max(0.0, *ends)
    step = _step((high - low) / TICKS)
    scale = (WIDTH - LEFT - RIGHT) / (high - low or 1.0)

    def at(value: float) -> float:
        return LEFT + (value - low) * scale

    bottom = TOP + PITCH * len(entries)
    marks: list[Mark] = list(_legend())
    for k in range(math.ceil(low / step), math.floor(high / step) + 1):
        x = at(k * step)
        marks.append(Line(x, TOP, x, bottom, "muted" if k == 0 else "line", 0.15))
        marks.append(Label(x, bottom + 2.6, significant(k * step, 2), SMALL, "muted", "middle"))
    marks.append(
        Label(
            LEFT + 0.5 * (WIDTH - LEFT - RIGHT), bottom + 5.6, f"peak [{units_of(entries)}]", SMALL, "muted", "middle"
        )
    )
    for n, each in enumerate(entries):
        y = TOP + PITCH * (n + 0.5)
        marks.append(Label(0.0, y - 0.5, plain(f"{each['motion']}, {each['joint']}", 26), SMALL, "ink"))
        marks.append(Label(0.0, y + 2.0, plain(each["device"], min(name, 26)), SMALL, "muted"))
        marks += _whiskers(each, y, at)
    return Drawing(WIDTH, bottom + FOOT - 1.5, tuple(marks), _words(entries))


def units_of(entries: Sequence[Mapping[str, Any]]) -> str:
    """`N·m`; `N·m, N` where some joints slide."""
    peaks = [effort["peak"] for each in entries for effort in each["approaches"].values()]
    return ", ".join(dict.fromkeys(peak["unit"] for peak in peaks)) or "N·m"


def _whiskers(entry: Mapping[str, Any], y: float, at: Any) -> Iterator[Mark]:
    """Model as a tall tick; A above, B on and the paired estimate below it, as dots with their doubt."""
    approaches = entry["approaches"]
    if _value(entry, "band_model") is not None:
        x = at(approaches["band_model"]["peak"]["value"])
        yield Line(x, y - 2.4, x, y + 2.4, "ink", 0.45)
    for approach, colour, shift in (("A", "identified", -1.4), ("B", "measured", 0.0), ("paired", "prior", 1.4)):
        value = _value(entry, approach)
        if value is not None:
            low, high = _span(entry, approach)
            yield Line(at(low), y + shift, at(high), y + shift, colour, 0.35)  # type: ignore[arg-type]
            yield Box(at(value) - 0.65, y + shift - 0.65, 1.3, 1.3, colour)  # type: ignore[arg-type]


def _legend() -> Iterator[Mark]:
    for k, (text, colour) in enumerate((("A", "identified"), ("B", "measured"), ("paired", "prior"))):
        yield Box(LEGEND + 8.0 * k, 1.2, 1.3, 1.3, colour)  # type: ignore[arg-type]
        yield Label(LEGEND + 8.0 * k + 2.2, 2.6, text, SMALL, "ink")
    yield Line(LEGEND + 28.4, 0.6, LEGEND + 28.4, 3.2, "ink", 0.45)
    yield Label(LEGEND + 30.0, 2.6, "band model", SMALL, "ink")


def _shown(entry: Mapping[str, Any]) -> bool:
    return any(_value(entry, approach) is not None for approach in ("A", "B", "paired"))


def _value(entry: Mapping[str, Any], approach: str) -> float | None:
    """None of what the data do not decide, as a mark without its doubt would look sure."""
    found, decided = entry["approaches"].get(approach), entry["peak"] is not None
    return found["peak"]["value"] if found and (decided or approach == "band_model") else None


def _span(entry: Mapping[str, Any], approach: str) -> tuple[float, ...]:
    """Two deviations to both sides; the value alone where none is known, and for the model; nothing for others."""
    value = _value(entry, approach)
    if value is None or approach == "prior":
        return ()
    std = entry["approaches"][approach]["peak"]["std"]
    doubt = 0.0 if std is None or approach == "band_model" else DEVIATIONS * std
    return value - doubt, value + doubt


def _step(least: float) -> float:
    """1, 2 or 5 times a power of ten, at least this."""
    if not (math.isfinite(least) and least > 0.0):
        return 1.0
    power = 10.0 ** math.floor(math.log10(least))
    return next(factor * power for factor in (1.0, 2.0, 5.0, 10.0) if factor * power >= least)


def _words(entries: Sequence[Mapping[str, Any]]) -> str:
    return (
        f"Peak supporting torque of {len(entries)} combinations of motion, joint and wear by A, B and the paired "
        "estimate and by the band model, with two standard deviations; the numbers stand in the table beside it."
    )
