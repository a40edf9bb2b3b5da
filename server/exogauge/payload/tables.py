"""[Payload] Tables II and III in full, from a payload's results: three methods, before and after the secondary zero."""

from __future__ import annotations

from exogauge.payload.schema import FigureResults, PayloadResults, Value
from exogauge.studies.csv_table import csv_table
from exogauge.studies.words.rounding import significant
from exogauge.terminal import text_table

WAYS = {
    "static": "postures alone, inertia ignored",
    "level": "base taken to be level",
    "rigid": "without what was named missing",
    "all": "everything taken out",
}
CHANNELS = ("fx", "fy", "fz", "mx", "my", "mz")
QUANTITIES = (("|f|", "N"), ("|τ|", "N·m"), *((each, "N" if each[0] == "f" else "N·m") for each in CHANNELS))
SHOWN = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz", "U", "V")
STATES = ("before", "after")


def identified_by_method(found: PayloadResults) -> dict[str, dict[str, float | None]]:
    """Table II: by way, then by name; None where a method does not tell it. m c of the static stage is m times c."""
    out: dict[str, dict[str, float | None]] = {}
    if found.static is not None:
        still = dict(found.static.by_method["tls"])
        moments = {f"m{axis}": still["m"] * still[f"c{axis}"] for axis in "xyz"}
        out["static"] = {name: (still | moments).get(name) for name in SHOWN}
    if found.dynamic is not None:
        if found.dynamic.level is not None:
            out["level"] = {name: found.dynamic.level.get(name) for name in SHOWN}
        if found.missing.without:
            out["rigid"] = {name: _of(found.missing.without, name) for name in SHOWN}
        out["all"] = {name: _of(_values(found), name) for name in SHOWN}
    return out


def left_by_method(found: PayloadResults) -> list[tuple[str, str, str, str, str, float, float, float]]:
    """Table III: log, way, before or after (44), quantity, unit; at t = 0, mean, standard deviation."""
    out = []
    for log, ways in found.tests.items():
        for way in (each for each in WAYS if each in ways):
            for state, figures in zip(STATES, (ways[way], ways[way].after_zero), strict=True):
                for (quantity, unit), three in zip(QUANTITIES, _columns(figures), strict=True):
                    out.append((log, way, state, quantity, unit, *three))
    return out


def as_text(found: PayloadResults) -> str:
    """Both, for a terminal."""
    parts, identified = [found.name], identified_by_method(found)
    units = {each.name: each.unit for each in _values(found)}
    rows = [[name, units.get(name, ""), *map(_cell, (each[name] for each in identified.values()))] for name in SHOWN]
    parts.append(text_table(("", "unit", *identified), rows))
    for log, ways in found.tests.items():
        helps = min(each.zero_helps for each in ways.values())
        parts.append(f"{log}: at t = 0, mean, std; after: the secondary zero (44), {100 * helps:.0f} % of the time")
        columns = [(way, state) for way in WAYS if way in ways for state in STATES]
        cells = {
            (way, state, name): three for each, way, state, name, _, *three in left_by_method(found) if each == log
        }
        rows = [
            [name, unit, *(" ".join(significant(x, 2) for x in cells[*column, name]) for column in columns)]
            for name, unit in QUANTITIES
        ]
        parts.append(text_table(("", "unit", *(f"{way}, {state}" for way, state in columns)), rows))
    return "\n".join([*parts, *(f"{way}: {words}" for way, words in WAYS.items() if way in identified)])


def as_csv(found: PayloadResults) -> bytes:
    """Table III, one row per log, method, state and quantity."""
    head = ("log", "method", "zero", "quantity", "unit", "first", "mean", "std")
    return csv_table(head, [list(each) for each in left_by_method(found)])


def _cell(value: float | None) -> str:
    return "–" if value is None else f"{value:.5g}"


def _values(found: PayloadResults) -> list[Value]:
    return [*(found.dynamic.values if found.dynamic else ()), *(found.static.values if found.static else ())]


def _of(values: list[Value], name: str) -> float | None:
    return next((each.value for each in values if each.name == name), None)


def _columns(figures: FigureResults) -> list[tuple[float, float, float]]:
    """At t = 0, mean and std of each quantity."""
    norms = [(figures.first[k], figures.mean[k], figures.std[k]) for k in (0, 1)]
    return [*norms, *((figures.axes[0][k], figures.axes[1][k], figures.axes[2][k]) for k in range(6))]
