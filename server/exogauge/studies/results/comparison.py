"""Several results.json side by side: one row per device, motion, joint and approach, one cell per result.

Every number is the one that stands in its results.json; a cell is None where a result has nothing for the row.

A comparison as a table to take away: CSV with every digit, LaTeX with as many as a number deserves.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Literal

from exogauge.studies.csv_table import csv_table
from exogauge.studies.words.rounding import significant, with_std

RMSE = {"A": "a", "B": "b", "paired": "paired", "prior": "prior"}  # approach: its letters in `rmse_…`
QUANTITIES = ("peak", "mean", "integral")
Content = Mapping[str, Any]


def compare(results: Sequence[Content]) -> dict[str, Any]:
    """results: content of each. {support, stiffness, identification: rows with `cells`; settings: those that differ,
    with their `values`}."""
    return {
        "support": _rows([_support_cells(each) for each in results], ("device", "motion", "joint", "approach")),
        "stiffness": _rows([_stiffness_cells(each) for each in results], ("device", "approach", "band")),
        "identification": _rows([_identification_cells(each) for each in results], ("kind", "unit")),
        "settings": differing([settings_of(each) for each in results]),
    }


def verdict(content: Content) -> dict[str, Any]:
    """What the search for missing effects said: verdict None where it was not made."""
    found = content.get("discrepancy") or {}
    return {
        "verdict": found.get("verdict"),
        "effects": [
            {"effect": each["effect"], "where": each["where"], "title": each.get("title"), "score": each["score"]}
            for each in found.get("findings", ())
        ],
    }


def settings_of(content: Content) -> dict[str, Any]:
    """What could make numbers differ, by dotted name: settings, versions, the robot, input files by their hash."""
    inputs = {each["file"]: each["sha256"] for each in content.get("inputs", ())}
    said = {"robot": content.get("robot"), "settings": content.get("settings"), "software": content.get("software")}
    steps = {each["step"]: each["status"] for each in content.get("steps", ())}
    flat = dict(_flat("", said | {"steps": steps}))
    return flat | {f"inputs.{file}": sha256 for file, sha256 in inputs.items()}


def differing(said: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """{name, values}: the names whose values are not the same everywhere; None where one is not said."""
    names = list(dict.fromkeys(name for each in said for name in each))
    rows = [{"name": name, "values": [each.get(name) for each in said]} for name in names]
    return [row for row in rows if any(value != row["values"][0] for value in row["values"])]


def _flat(prefix: str, value: Any) -> Iterable[tuple[str, Any]]:
    if isinstance(value, Mapping):
        for key, item in value.items():
            yield from _flat(f"{prefix}.{key}" if prefix else str(key), item)
    else:
        yield prefix, value


def _rows(cells: Sequence[Mapping[tuple[str, ...], Any]], names: Sequence[str]) -> list[dict[str, Any]]:
    """In the order in which the results first name them."""
    keys = dict.fromkeys(key for each in cells for key in each)
    return [{**dict(zip(names, key, strict=True)), "cells": [each.get(key) for each in cells]} for key in keys]


def _support_cells(content: Content) -> dict[tuple[str, ...], Any]:
    cells: dict[tuple[str, ...], Any] = {}
    for entry in content.get("support") or ():
        for approach, numbers in entry["approaches"].items():
            letters = RMSE.get(approach)
            cells[(entry["device"], entry["motion"], entry["joint"], approach)] = {
                "unit": entry["unit"],
                "main": entry["main"],
                "rmse": None if letters is None else entry.get(f"rmse_{letters}"),
                "rmse_steady": None if letters is None else entry["rmse_steady"].get(letters),
                **{name: numbers.get(name) for name in QUANTITIES},
                "spread": numbers.get("spread"),
                "motion_equality": (entry.get("motion_equality") or {}).get("verdict") if approach == "A" else None,
            }
    return cells


def _stiffness_cells(content: Content) -> dict[tuple[str, ...], Any]:
    kept = ("group", "stiffness_n_per_m", "natural_length_m", "truth_n_per_m", "error_percent", "identifiable")
    return {
        (each["device"], each["approach"], each["band"]): {key: each.get(key) for key in kept}
        for each in content.get("stiffness") or ()
    }


def _identification_cells(content: Content) -> dict[tuple[str, ...], Any]:
    kept = ("rmse_prior", "rmse_identified", "noise_floor", "held_out")
    return {
        (each["kind"], each["unit"]): {key: each.get(key) for key in kept}
        for each in content.get("identification", {}).get("summary", ())
    }


Table = Literal["support", "stiffness"]
KEYS: Mapping[Table, tuple[str, ...]] = {
    "support": ("device", "motion", "joint", "approach"),
    "stiffness": ("device", "approach", "band"),
}
PLAIN: Mapping[Table, tuple[str, ...]] = {
    "support": ("unit", "rmse", "rmse_steady", "spread", "motion_equality"),
    "stiffness": ("group", "truth_n_per_m", "error_percent", "identifiable"),
}
WITH_STD: Mapping[Table, tuple[str, ...]] = {
    "support": ("peak", "mean", "integral"),
    "stiffness": ("stiffness_n_per_m", "natural_length_m"),
}
SHOWN: Mapping[Table, tuple[tuple[str, str], ...]] = {  # in LaTeX: quantity, heading
    "support": (("rmse", "RMSE"), ("peak", "peak"), ("mean", "mean")),
    "stiffness": (("stiffness_n_per_m", "N/m"), ("error_percent", r"error \%")),
}
ESCAPED = {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}"} | {
    sign: f"\\{sign}" for sign in "&%$#_{}"
}
RAISED = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")


def as_csv(comparison: Mapping[str, Any], jobs: Sequence[Mapping[str, Any]], table: Table) -> bytes:
    """One row per row of the comparison and job. jobs: {id, name, verdict} in the order of the cells."""
    columns = (
        *("job", "study", "discrepancy"),
        *KEYS[table],
        *PLAIN[table],
        *(name for quantity in WITH_STD[table] for name in (quantity, f"{quantity}_std")),
    )

    def row(entry: Mapping[str, Any], job: Mapping[str, Any], cell: Mapping[str, Any]) -> list[Any]:
        numbers = [cell.get(quantity) or {} for quantity in WITH_STD[table]]
        return [
            *(job["id"], job["name"], job["verdict"]),
            *(entry[key] for key in KEYS[table]),
            *(cell.get(name) for name in PLAIN[table]),
            *(value for number in numbers for value in (number.get("value"), number.get("std"))),
        ]

    rows = (
        row(entry, job, cell)
        for entry in comparison[table]
        for job, cell in zip(jobs, entry["cells"], strict=True)
        if cell is not None
    )
    return csv_table(columns, rows)


def as_latex(comparison: Mapping[str, Any], jobs: Sequence[Mapping[str, Any]], table: Table) -> bytes:
    """A `tabular` that needs no package: one column group per job."""
    keys, shown = KEYS[table], SHOWN[table]
    heads = " & ".join(f"\\multicolumn{{{len(shown)}}}{{c}}{{{escaped(str(job['name']))}}}" for job in jobs)
    names = " & ".join([*keys, *(heading for _ in jobs for _, heading in shown)])
    lines = [
        f"\\begin{{tabular}}{{{'l' * len(keys)}{'r' * (len(shown) * len(jobs))}}}",
        "\\hline",
        f"{' & ' * (len(keys) - 1)} & {heads} \\\\",
        f"{names} \\\\",
        "\\hline",
    ]
    for entry in comparison[table]:
        cells = (_cell(cell, quantity) for cell in entry["cells"] for quantity, _ in shown)
        lines.append(" & ".join([*(escaped(str(entry[key])) for key in keys), *cells]) + r" \\")
    return "\n".join([*lines, "\\hline", "\\end{tabular}", ""]).encode()


def escaped(text: str) -> str:
    """Text that LaTeX prints and does not obey."""
    return "".join(ESCAPED.get(sign, sign if sign.isprintable() else " ") for sign in text)


def _cell(cell: Mapping[str, Any] | None, quantity: str) -> str:
    number = None if cell is None else cell.get(quantity)
    if number is None:
        return "--"
    if not isinstance(number, Mapping):
        return _math(significant(float(number)))
    if number.get("value") is None:
        return "--"
    value, std = with_std(float(number["value"]), float(number["std"] or 0.0))
    return _math(value) if std == "–" else _math(f"{value} \\pm {std}")


def _math(text: str) -> str:
    plain = re.sub(r"·10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)", lambda power: f" \\cdot 10^{{{power[1].translate(RAISED)}}}", text)
    return "--" if text == "–" else f"${plain.replace(chr(0x2212), '-')}$"
