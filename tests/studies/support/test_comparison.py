"""Results side by side: the numbers of each, nothing mixed up, nothing hidden."""

from __future__ import annotations

import copy
import csv
import io
import json
from typing import Any

import pytest

from exogauge.devices.result import StiffnessResult
from exogauge.studies.results.comparison import as_csv, as_latex, compare, verdict
from exogauge.studies.results.plain_values import finite
from exogauge.studies.results.support_results import stiffness_entries, support_entries
from exogauge.support.result import SupportResult


@pytest.fixture
def content(support: SupportResult, stiffness: tuple[StiffnessResult, ...]) -> dict[str, Any]:
    """results.json of a study with devices, as far as a comparison reads it."""
    made = {
        "robot": "Small",
        "settings": {"cutoff_hz": 10.0, "prior": "per_parameter"},
        "software": {"numpy": "2.4"},
        "inputs": [{"file": "logs/a.csv", "sha256": "a" * 64, "bytes": 1}],
        "steps": [{"step": "identify", "status": "done"}],
        "identification": {"summary": []},
        "support": support_entries(support),
        "stiffness": stiffness_entries(stiffness),
        "discrepancy": None,
    }
    return json.loads(json.dumps(finite(made), allow_nan=False))


def test_every_number_is_that_of_its_result(content: dict[str, Any]) -> None:
    other = copy.deepcopy(content)
    other["support"] = [other["support"][0]]
    other["support"][0]["approaches"]["A"]["mean"]["value"] = 123.5
    rows = compare([content, other])["support"]
    assert len(rows) == sum(len(entry["approaches"]) for entry in content["support"])
    for row in rows:
        (entry,) = [e for e in content["support"] if all(e[k] == row[k] for k in ("device", "motion", "joint"))]
        numbers = entry["approaches"][row["approach"]]
        assert row["cells"][0]["peak"] == numbers["peak"]
        assert row["cells"][0]["mean"] == numbers["mean"]
        rmse = {
            "A": entry["rmse_a"],
            "B": entry["rmse_b"],
            "paired": entry["rmse_paired"],
            "prior": entry["rmse_prior"],
            "band_model": None,
        }
        assert row["cells"][0]["rmse"] == rmse[row["approach"]]
        here = entry is content["support"][0]
        assert (row["cells"][1] is not None) == here
        if here and row["approach"] == "A":
            assert row["cells"][1]["mean"]["value"] == 123.5


def test_only_settings_that_differ_are_told(content: dict[str, Any]) -> None:
    other = copy.deepcopy(content)
    assert compare([content, other])["settings"] == []
    other["settings"] |= {"cutoff_hz": None, "solver": "rows"}
    other["inputs"].append({"file": "logs/b.csv", "sha256": "b" * 64, "bytes": 1})
    assert compare([content, other])["settings"] == [
        {"name": "settings.cutoff_hz", "values": [10.0, None]},
        {"name": "settings.solver", "values": [None, "rows"]},
        {"name": "inputs.logs/b.csv", "values": [None, "b" * 64]},
    ]


def test_a_search_that_was_not_made_has_no_verdict() -> None:
    assert verdict({"discrepancy": None}) == {"verdict": None, "effects": []}
    found = {
        "verdict": "effects",
        "findings": [{"effect": "stribeck", "where": {"joint": "hip"}, "score": 0.9, "rank": 1}],
    }
    assert verdict({"discrepancy": found})["effects"] == [
        {"effect": "stribeck", "where": {"joint": "hip"}, "title": None, "score": 0.9}
    ]


JOBS = [{"id": "1", "name": "=1+1 & 50 % of_it", "verdict": None}, {"id": "2", "name": "Second", "verdict": "none"}]


@pytest.mark.parametrize("table", ["support", "stiffness"])
def test_a_table_for_a_spreadsheet_has_raw_numbers_and_harmless_text(content: dict[str, Any], table: Any) -> None:
    found = compare([content, content])
    read = list(csv.DictReader(io.StringIO(as_csv(found, JOBS, table).decode())))
    assert len(read) == 2 * len(found[table])
    assert {row["study"] for row in read} == {"'=1+1 & 50 % of_it", "Second"}
    numbers = [row["mean" if table == "support" else "stiffness_n_per_m"] for row in read[::2]]
    key = "mean" if table == "support" else "stiffness_n_per_m"
    assert [float(number) for number in numbers] == [row["cells"][0][key]["value"] for row in found[table]]


def test_a_table_for_a_paper_is_rounded_by_its_uncertainty_and_obeys_no_text(content: dict[str, Any]) -> None:
    content["support"] = content["support"][:1]
    content["support"][0]["approaches"] = {"A": content["support"][0]["approaches"]["A"]}
    content["support"][0]["approaches"]["A"]["mean"] = {"value": -5.03162, "std": 0.0412, "unit": "N·m"}
    content["support"][0] |= {"rmse_a": 1.23456e-7, "joint": "a_b"}
    text = as_latex(compare([content]), JOBS[:1], "support").decode()
    assert r"$-5.032 \pm 0.041$" in text
    assert r"$1.23 \cdot 10^{-7}$" in text
    assert r"=1+1 \& 50 \% of\_it" in text
    assert r" & a\_b & A & " in text
    assert text.count("&") - text.count(r"\&") == 6 + 4 + 6
    assert text.isascii() or "·" not in text
