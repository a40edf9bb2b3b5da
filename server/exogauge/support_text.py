"""Supporting torque and stiffness of results.json as text for a terminal, like Tables 2 and 3 of [Evaluator]."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from exogauge.studies.words.rounding import between, rounded, significant, with_std
from exogauge.terminal import text_table

APPROACHES = ("A", "B", "prior")


def support_text(result: Mapping[str, Any]) -> str:
    """RMSE of A, B and the maker's values against the band model, motion by motion, at the joints that matter."""
    motions = list(dict.fromkeys(each["motion"] for each in result.get("support", ())))
    entries = [each for motion in motions for each in result["support"] if each["main"] and each["motion"] == motion]
    if not entries:
        return ""
    columns = ("motion", "device", "joint", "A", "B", "maker's", "A steady", "B steady", "A null", "B null")
    rows = [
        [
            *(each["motion"], each["device"], each["joint"]),
            *(figures(each[f"rmse_{approach}"]) for approach in ("a", "b", "prior")),
            *(figures(each["rmse_steady"][approach]) for approach in ("a", "b")),
            *(figures(each["null"][approach], 2) for approach in ("a", "b")),
        ]
        for each in entries
    ]
    return "\n".join(
        [
            "SUPPORTING TORQUE: root mean square of estimate minus band model, N·m",
            "A: run without minus run with the device; B: model minus measurement; maker's: B with the maker's values",
            "",
            text_table(columns, rows),
            "",
            "steady: only samples in which both runs move steadily. null: what the approach finds on logs without the",
            f"device, where the truth is zero. {alike(entries)}",
            "",
            text_table(
                ("motion", "device", "joint", "peak by A", "peak by B", "band model"),
                [peak_row(each) for each in entries],
            ),
        ]
    )


def alike(entries: Sequence[Mapping[str, Any]]) -> str:
    """Whether the motions that A compares are the same."""
    compared = [each for each in entries if each["motion_equality"]]
    if not compared:
        return "No motion was recorded without the device, so there is no A."
    unlike = [each for each in compared if each["motion_equality"]["verdict"] != "equal"]
    if not unlike:
        return "All motions that A compares are alike."
    named = (f"{each['motion']} with {each['device']} at {each['joint']}" for each in unlike)
    return f"Motions that A compares are not quite alike: {', '.join(named)}."


def peak_row(entry: Mapping[str, Any]) -> list[str]:
    def peak(approach: str) -> str:
        found = entry["approaches"].get(approach)
        return plus_minus(found["peak"]) if found else ""

    model = entry["approaches"].get("band_model")
    shown = figures(model["peak"]["value"]) if model else ""
    return [entry["motion"], entry["device"], entry["joint"], peak("A"), peak("B"), shown]


def stiffness_text(result: Mapping[str, Any]) -> str:
    """Tables 2 and 3: the ground truth and each approach, with its error, standard deviation and interval."""
    groups: dict[tuple[str, str], list[Mapping[str, Any]]] = {}
    for each in result.get("stiffness", ()):
        chosen = groups.setdefault((each["device"], each["group"]), [])
        if all(other["approach"] != each["approach"] for other in chosen):
            chosen.append(each)  # bands of one group share their stiffness: the first stands for all
    if not groups:
        return ""
    rows = []
    for (device, group), entries in groups.items():
        truth = entries[0]["truth_n_per_m"]
        if truth is not None:
            rows.append([device, group, "ground truth", significant(truth, 4), "", "", "", ""])
        rows += [stiffness_row(each) for each in sorted(entries, key=lambda each: APPROACHES.index(each["approach"]))]
    columns = ("device", "bands", "from", "stiffness", "± std", "95 % interval", "error %", "")
    return "\n".join(
        [
            "STIFFNESS OF THE BANDS: from the supporting torques of all logs with the device, N/m",
            "",
            text_table(columns, rows),
        ]
    )


def stiffness_row(entry: Mapping[str, Any]) -> list[str]:
    found = entry["stiffness_n_per_m"]
    value, std = with_std(number(found["value"]), number(found["std"]))
    low, high = entry["interval_95"]["stiffness_n_per_m"]
    interval = "" if low is None or high is None else between(low, high)
    error = "" if entry["error_percent"] is None else rounded(entry["error_percent"], 1)
    words = {"A": "approach A", "B": "approach B", "prior": "maker's values"}
    mark = "" if entry["identifiable"] else "not decided"
    return [entry["device"], entry["group"], words[entry["approach"]], value, std, interval, error, mark]


def plus_minus(found: Mapping[str, Any]) -> str:
    if found["value"] is None:
        return ""
    if not found["std"]:
        return significant(found["value"])
    return " ± ".join(with_std(found["value"], found["std"]))


def number(value: float | None) -> float:
    return math.nan if value is None else value


def figures(value: float | None, digits: int = 3) -> str:
    return "" if value is None else significant(value, digits)
