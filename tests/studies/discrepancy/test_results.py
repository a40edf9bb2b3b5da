"""results.json holds what the search for missing effects found, by the contract's names."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from exogauge.findings.result import Discrepancy
from exogauge.identification.result import Identification
from exogauge.studies.evaluate import write
from exogauge.studies.intake.open import open_study
from exogauge.studies.results.discrepancy_results import discrepancy_entry
from exogauge.studies.results.document import Evaluation, results, to_json
from exogauge.studies.results.plain_values import finite


@pytest.fixture(scope="module")
def entry(discrepancy: Discrepancy) -> dict[str, Any]:
    return json.loads(json.dumps(finite(discrepancy_entry(discrepancy)), allow_nan=False))


def test_the_keys_are_those_of_the_contract(entry: dict[str, Any]) -> None:
    assert entry.keys() >= {
        "verdict", "findings", "chain", "wear_chain", "located", "unexplained", "rejected", "lineage", "candidates",
        "notes", "before_after",
    }  # fmt: skip
    found = entry["findings"][0]
    assert found.keys() >= {
        "rank", "effect", "where", "parameters", "held_out", "score", "evidence", "alternatives", "also_possible",
        "motion",
    }  # fmt: skip
    assert found["held_out"].keys() == {
        "channel",
        "unit",
        "rmse_before",
        "rmse_after",
        "noise_floor",
        "log",
        "channel_words",
    }
    assert entry["chain"][0].keys() >= {"step", "rmse", "noise_floor", "worst", "worst_rmse", "worst_floor"}
    for other in (*found["alternatives"], *found["also_possible"], *entry["rejected"]):
        assert other.keys() == {"effect", "where", "title", "score", "reason", "objection"}


def test_a_step_of_the_chain_is_data_and_the_sentence_is_made_of_it(entry: dict[str, Any]) -> None:
    first, *_, last = entry["chain"]
    assert (first["what"], first["effect"], first["where"]) == ("bands", None, None)
    assert (last["what"], last["effect"], last["where"]) == ("effect", "payload", {"link": "r_arm"})
    assert last["step"] == f"+ {entry['findings'][1]['title']}"


def test_a_finding_says_what_where_how_large_and_how_it_is_known(entry: dict[str, Any]) -> None:
    first, second = entry["findings"]
    assert (first["effect"], first["where"]) == ("stribeck", {"joint": "torso_pitch"})
    assert (second["effect"], second["where"]) == ("payload", {"link": "r_arm"})
    assert first["title"] == "Stribeck friction at torso_pitch"
    assert first["parameters"]["tau_b"] == {"value": 3.04, "std": 0.21, "unit": "N·m"}
    assert first["held_out"]["rmse_after"] == 1.083
    assert first["evidence"].startswith("torso_pitch: Friction is larger at low speed")


def test_the_curve_of_the_evidence_can_be_drawn_again(entry: dict[str, Any]) -> None:
    curve = entry["findings"][0]["curve"]
    assert curve["coordinate"]["name"] == "velocity"
    assert curve["coordinate"]["unit"] == "rad/s"
    assert {len(curve[name]) for name in ("before", "after", "spread", "model")} == {36}
    assert len(curve["coordinate"]["values"]) == 36
    assert curve["before"][3] is None  # an empty bin


def test_what_is_not_a_number_is_null(entry: dict[str, Any]) -> None:
    assert entry["rejected"][2] == {
        "effect": "base_tilt", "where": {"base": True}, "title": "a tilted base", "score": None,
        "reason": "too little steady motion that was not fitted to judge it: 0 of 5\u00a0s",
        "objection": {"why": "too_short", "value": 0.0, "beside": 5.0, "of": [], "sizes": {}},
    }  # fmt: skip


def test_before_and_after_of_a_quantity_stand_together(entry: dict[str, Any]) -> None:
    assert entry["before_after"]["stiffness of group A by approach B · suit"] == {
        "before": {"value": 241.0, "std": 6.0, "unit": "N/m"},
        "after": {"value": 199.5, "std": 4.0, "unit": "N/m"},
        "moves": True,
    }


def test_a_skipped_step_leaves_null_and_its_reason(pristine: Path, identification: Identification) -> None:
    with open_study(pristine) as study:
        content = results(
            Evaluation(
                study.name, study.robot, study.settings, study.steps, study.bundle.inputs, [], identification, [], {}
            )
        )
    assert content["discrepancy"] is None
    assert discrepancy_entry(None) is None


@pytest.mark.slow
def test_the_files_of_an_evaluation_hold_it(
    pristine: Path, identification: Identification, discrepancy: Discrepancy, tmp_path: Path
) -> None:
    with open_study(pristine) as study:
        whole = Evaluation(
            study.name, study.robot, study.settings, study.steps, study.bundle.inputs, [], identification, [], {},
            discrepancy=discrepancy,
        )  # fmt: skip
        write(study, whole, tmp_path / "out")
        again = to_json(results(whole)["discrepancy"])
    found = json.loads((tmp_path / "out" / "results.json").read_text(), parse_constant=pytest.fail)
    assert found["discrepancy"] == json.loads(again)
    assert "Stribeck friction at torso_pitch" in (tmp_path / "out" / "report.html").read_text()
