"""Two documents walked: what is called, what is a number, what only reads differently."""

from __future__ import annotations

import copy
import math
from typing import Any

import pytest
from tests.gate.difference import ABSENT, difference
from tests.gate.report import is_same, report
from tests.gate.walk import leaves

DOCUMENT: dict[str, Any] = {
    "software": {"numpy": "2.4"},
    "identification": {
        "condition": 15.3,
        "parameters": [
            {"name": "m[a]", "value": 2.0, "std": 0.5, "identifiable": True},
            {"name": "tau_o[a]", "value": 1e-9, "std": 0.1, "identifiable": True},
        ],
        "unidentifiable": ["m[b]", "m[c]"],
    },
    "discrepancy": {
        "verdict": "effects",
        "findings": [
            {"effect": "stribeck", "where": {"joint": "waist"}, "score": 0.9, "curve": [1.0, 2.0, 3.0]},
            {"effect": "stribeck", "where": {"joint": "knee"}, "score": 0.8, "curve": []},
        ],
        "sentence": "Friction of 2.47 N·m at the waist.",
        "left": None,
    },
}
RTOL = 1e-9


@pytest.fixture
def other() -> dict[str, Any]:
    return copy.deepcopy(DOCUMENT)


def test_a_document_equals_itself_and_every_number_is_compared(other: dict[str, Any]) -> None:
    found = difference(DOCUMENT, other)
    assert (found.names, found.numbers, found.sentences) == ((), (), ())
    assert found.compared == 1 + 4 + 2 + 3 + 5  # condition, value and std, scores, a curve, lengths of five lists


def test_versions_of_the_environment_are_not_compared(other: dict[str, Any]) -> None:
    other["software"]["numpy"] = "3.0"
    assert is_same({"case": difference(DOCUMENT, other)}, RTOL)


def test_a_number_that_moves_is_found_by_what_its_entry_is_called(other: dict[str, Any]) -> None:
    other["discrepancy"]["findings"][0]["score"] = 0.45
    (change,) = difference(DOCUMENT, other).numbers
    assert change.path == "discrepancy.findings[stribeck waist].score"
    assert change.by == pytest.approx(0.5)
    assert not is_same({"case": difference(DOCUMENT, other)}, 0.4)
    assert is_same({"case": difference(DOCUMENT, other)}, 0.6)


def test_the_farthest_move_comes_first(other: dict[str, Any]) -> None:
    other["identification"]["condition"] *= 1.01
    other["discrepancy"]["findings"][1]["score"] *= 1.5
    other["discrepancy"]["findings"][0]["curve"][2] *= 1.1
    moves = [change.by or 0.0 for change in difference(DOCUMENT, other).numbers]
    assert len(moves) == 3
    assert moves == sorted(moves, reverse=True)


def test_a_value_moves_against_its_own_doubt(other: dict[str, Any]) -> None:
    other["identification"]["parameters"][1]["value"] = 2e-9
    (change,) = difference(DOCUMENT, other).numbers
    assert change.by == pytest.approx(1e-9 / 0.1)


def test_entries_in_another_order_differ_by_their_order_alone(other: dict[str, Any]) -> None:
    other["discrepancy"]["findings"].reverse()
    found = difference(DOCUMENT, other)
    assert [change.path for change in found.names] == ["discrepancy.findings[order]"]
    assert found.numbers == ()


def test_an_entry_that_came_moves_no_other(other: dict[str, Any]) -> None:
    other["discrepancy"]["findings"].insert(0, {"effect": "backlash", "where": {"joint": "knee"}, "score": 0.99})
    found = difference(DOCUMENT, other)
    (change,) = found.names
    assert (change.path, change.before) == ("discrepancy.findings[backlash knee]", ABSENT)
    assert [each.path for each in found.numbers] == ["discrepancy.findings[length]"]


def test_a_finding_of_another_name_is_one_that_went_and_one_that_came(other: dict[str, Any]) -> None:
    other["discrepancy"]["findings"][0]["effect"] = "presliding"
    found = difference(DOCUMENT, other)
    assert [change.path for change in found.names if change.after == ABSENT] == ["discrepancy.findings[stribeck waist]"]
    assert [change.path for change in found.names if change.before == ABSENT] == [
        "discrepancy.findings[presliding waist]"
    ]


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("discrepancy", "verdict"), "none"),
        (("discrepancy", "left"), "above"),
        (("discrepancy", "findings"), []),
        (("discrepancy", "findings"), None),
        (("identification", "condition"), None),
        (("identification", "unidentifiable"), ["m[b]"]),
        (("identification",), None),
    ],
)
def test_a_verdict_a_name_or_an_answer_that_is_gone_differs_whatever_is_allowed(
    other: dict[str, Any], path: tuple[str, ...], value: Any
) -> None:
    inner = other
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] = value
    found = difference(DOCUMENT, other)
    assert any(change.path.startswith(".".join(path)) for change in found.names)
    assert not is_same({"case": found}, math.inf)


def test_a_missing_key_differs(other: dict[str, Any]) -> None:
    del other["identification"]["condition"]
    (change,) = difference(DOCUMENT, other).names
    assert (change.path, change.before, change.after) == ("identification.condition", 15.3, ABSENT)


def test_a_section_that_is_gone_is_one_change_and_stands_behind_names_that_changed(other: dict[str, Any]) -> None:
    del other["identification"]
    other["discrepancy"]["verdict"] = "none"
    assert [change.path for change in difference(DOCUMENT, other).names] == ["discrepancy.verdict", "identification"]


def test_one_warning_less_is_a_difference_though_it_is_a_sentence() -> None:
    before, after = {"warnings": ["It is late.", "It is cold."]}, {"warnings": ["It is late."]}
    assert not is_same({"case": difference(before, after)}, RTOL)


def test_true_is_no_number(other: dict[str, Any]) -> None:
    other["identification"]["parameters"][0]["identifiable"] = 1
    assert [change.path for change in difference(DOCUMENT, other).names] == [
        "identification.parameters[m[a]].identifiable"
    ]


def test_what_is_no_number_equals_itself_and_nothing_else(other: dict[str, Any]) -> None:
    nan = copy.deepcopy(DOCUMENT)
    nan["identification"]["condition"] = math.nan
    assert difference(nan, copy.deepcopy(nan)).numbers == ()
    (change,) = difference(DOCUMENT, nan).numbers
    assert change.by == math.inf
    nan["identification"]["condition"], other["identification"]["condition"] = math.inf, 1.0
    assert difference(nan, other).numbers[0].by == math.inf


def test_two_that_are_nothing_but_rounding_are_the_same() -> None:
    assert difference({"a": 1e-17}, {"a": -3e-17}).numbers == ()


def test_a_sentence_is_told_and_is_no_difference(other: dict[str, Any]) -> None:
    other["discrepancy"]["sentence"] = "At the waist friction of 2.47 N·m."
    found = difference(DOCUMENT, other)
    assert [change.path for change in found.sentences] == ["discrepancy.sentence"]
    assert is_same({"case": found}, RTOL)


def test_entries_called_the_same_are_told_apart() -> None:
    entries = [{"log": "a", "detail": 1.0}, {"log": "a", "detail": 2.0}]
    assert leaves(entries)["[a #2].detail"] == 2.0


def test_the_report_tells_names_before_numbers_and_counts_both(other: dict[str, Any]) -> None:
    other["discrepancy"]["verdict"] = "none"
    other["identification"]["condition"] *= 1.01
    text = report({"sample": difference(DOCUMENT, other), "blind/case_0001": difference(DOCUMENT, DOCUMENT)}, RTOL)
    assert text.index("discrepancy.verdict: 'effects' -> 'none'") < text.index("identification.condition: 15.3")
    assert "2 cases, 30 numbers: 1 names changed, 1 numbers moved, 1 of them by more than 1e-09" in text
