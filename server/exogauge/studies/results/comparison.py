"""Several results.json side by side: one row per device, motion, joint and approach, one cell per result.

Every number is the one that stands in its results.json; a cell is None where a result has nothing for the row.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

RMSE = {"A": "a", "B": "b", "prior": "prior"}  # approach: its letters in `rmse_…`
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
