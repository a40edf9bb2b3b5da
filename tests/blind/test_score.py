"""Scores of results written by hand: right, wrong, silent."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from exogauge.blind.answers import write_answers
from exogauge.blind.score import score, score_text
from exogauge.errors import BadInput


def hidden(effect: str, joint: str, visible: bool = True) -> dict[str, Any]:
    return {"effect": effect, "where": {"joint": joint}, "visible": visible, "ratio": 4.0 if visible else 1.5}


ANSWERS = [
    {"case": "case_0001", "robot": "arm6", "effects": [hidden("stribeck", "joint_2")], "clutter": []},
    {
        "case": "case_0002",
        "robot": "arm6",
        "effects": [hidden("backlash", "joint_3", False)],
        "clutter": [hidden("stribeck", "joint_1")],
    },
    {
        "case": "case_0003",
        "robot": "arm6",
        "effects": [hidden("stribeck", "joint_1"), hidden("torque_delay", "all")],
        "clutter": [],
    },
    {"case": "case_0004", "robot": "arm6", "effects": [], "clutter": []},
    {
        "case": "case_0005",
        "robot": "arm6",
        "effects": [],
        "clutter": [hidden("torque_ripple", "joint_4", False)],
    },
]


def finding(rank: int, effect: str, joint: str, after: float = 0.1, **more: Any) -> dict[str, Any]:
    held_out = {"channel": f"tau.{joint}", "unit": "N·m", "rmse_before": 0.3, "rmse_after": after, "noise_floor": 0.1}
    return {"rank": rank, "effect": effect, "where": {"joint": joint}, "held_out": held_out, **more}


def other(effect: str, joint: str, score: float = 0.5) -> dict[str, Any]:
    return {"effect": effect, "where": {"joint": joint}, "score": score}


def benchmark(out: Path, said: dict[str, list[dict[str, Any]] | None]) -> Path:
    """A folder with `ANSWERS` and one result per case; None: the step was skipped."""
    write_answers(out, 1, ANSWERS)
    (out / "results").mkdir()
    for case, findings in said.items():
        discrepancy = None if findings is None else {"verdict": "effects" if findings else "none", "findings": findings}
        record = {"case": case, "code": "x", "seconds": 2.0, "error": None, "discrepancy": discrepancy}
        (out / "results" / f"{case}.json").write_text(json.dumps(record), encoding="utf-8")
    return out


PERFECT: dict[str, list[dict[str, Any]] | None] = {
    "case_0001": [finding(1, "stribeck", "joint_2")],
    "case_0002": [finding(1, "backlash", "joint_3")],
    "case_0003": [finding(2, "stribeck", "joint_1"), finding(1, "torque_delay", "all")],
    "case_0004": [],
    "case_0005": [],
}


def test_a_perfect_evaluation_gets_everything(tmp_path: Path) -> None:
    found = score(benchmark(tmp_path, PERFECT))
    assert (found["cases"], found["missing"], found["failed"]) == (5, 0, [])
    assert found["visible"]["n"] == found["visible"]["top1"] == found["visible"]["exact"] == 1
    assert found["visible_without_clutter"]["top1"] == 1
    assert found["visible_with_clutter"]["n"] == 0
    assert found["all"]["n"] == found["all"]["top1"] == found["all"]["top3"] == 2
    assert found["with_clutter"]["n"] == found["without_clutter"]["n"] == 1
    assert found["clean"]["n"] == 2
    assert found["clean"]["false_alarms"] == 0
    assert found["pairs"] == {"n": 1, "both": 1, "exact": 1, "one": 0}
    assert found["restored"] == {"n": 3, "within_1_1": 3, "named": {"n": 3, "within_1_1": 3}}
    assert found["wrong_names"]["names"] == 0
    assert found["confusion"] == [
        {"truth": "backlash", "named": "backlash", "n": 1, "right_place": 1},
        {"truth": "none", "named": "none", "n": 2, "right_place": 2},
        {"truth": "stribeck", "named": "stribeck", "n": 1, "right_place": 1},
    ]


def test_an_evaluation_that_is_always_wrong_gets_nothing(tmp_path: Path) -> None:
    wrong = {case: [finding(1, "joint_spring", "joint_6", after=0.2)] for case in PERFECT}
    found = score(benchmark(tmp_path, dict(wrong)))
    assert found["visible"]["top1"] == found["all"]["top1"] == found["all"]["top3"] == found["pairs"]["both"] == 0
    assert found["clean"]["false_alarms"] == 2
    assert found["wrong_names"] == {"n": 3, "cases": 3, "beside_the_truth": 0, "names": 3}
    assert found["restored"] == {"n": 0, "within_1_1": 0, "named": {"n": 3, "within_1_1": 0}}
    assert {(each["truth"], each["named"]) for each in found["confusion"]} == {
        ("stribeck", "joint_spring"), ("backlash", "joint_spring"), ("none", "joint_spring")
    }  # fmt: skip


def test_only_cases_that_are_right_count_as_restored(tmp_path: Path) -> None:
    said = {
        **PERFECT,
        "case_0001": [finding(1, "stribeck", "joint_2", after=0.12)],
        "case_0002": [finding(1, "joint_spring", "joint_3")],
        "case_0003": [finding(1, "torque_delay", "all")],  # one of two
    }
    restored = score(benchmark(tmp_path, said))["restored"]
    assert restored == {"n": 1, "within_1_1": 0, "named": {"n": 3, "within_1_1": 2}}


@pytest.mark.parametrize(("log", "restored"), [("", 1), ("id_2", 0)])
def test_what_a_finding_leaves_is_what_is_left_once_all_are_in_the_model(
    tmp_path: Path, log: str, restored: int
) -> None:
    said = finding(1, "stribeck", "joint_2", after=0.2)
    said["held_out"]["log"] = log
    out = benchmark(tmp_path, {"case_0001": [said]})
    path = out / "results" / "case_0001.json"
    record = json.loads(path.read_text(encoding="utf-8"))
    record["discrepancy"]["chain"] = [{"worst_rmse": 0.2, "worst_floor": 0.1}, {"worst_rmse": 0.1, "worst_floor": 0.1}]
    path.write_text(json.dumps(record), encoding="utf-8")
    assert score(out)["restored"]["within_1_1"] == restored


@pytest.mark.parametrize("nothing", [[], None])
def test_an_evaluation_that_says_nothing_raises_no_alarm_and_finds_nothing(tmp_path: Path, nothing) -> None:
    found = score(benchmark(tmp_path, dict.fromkeys(PERFECT, nothing)))
    assert found["all"]["top1"] == found["all"]["top3"] == found["clean"]["false_alarms"] == 0
    assert found["all"]["silent"] == 2
    assert found["restored"]["n"] == found["wrong_names"]["n"] == 0
    assert "0 of 2 (0 %, below 78 %)" in score_text(found)
    assert found["interval_95"]["clean"]["false_alarms"] == [0.0, pytest.approx(1.0 - 0.05**0.5, abs=1e-4)]


def test_the_right_effect_at_the_wrong_place_is_wrong(tmp_path: Path) -> None:
    found = score(benchmark(tmp_path, {**PERFECT, "case_0001": [finding(1, "stribeck", "joint_3")]}))
    assert found["visible"]["top1"] == 0
    assert {"truth": "stribeck", "named": "stribeck", "n": 1, "right_place": 0} in found["confusion"]


def test_alternatives_of_the_first_finding_count_among_three_by_their_score(tmp_path: Path) -> None:
    others = [other("stribeck", "joint_2", 0.2), other("presliding", "joint_2", 0.6), other("backlash", "joint_2", 0.1)]
    said = finding(1, "nonlinear_viscous", "joint_2", alternatives=others)
    found = score(benchmark(tmp_path, {**PERFECT, "case_0001": [said]}))
    assert (found["visible"]["top1"], found["visible"]["top3"]) == (0, 1)
    said["alternatives"][0]["score"] = 0.01
    (tmp_path / "again").mkdir()
    assert score(benchmark(tmp_path / "again", {**PERFECT, "case_0001": [said]}))["visible"]["top3"] == 0


@pytest.mark.parametrize(("others", "counts"), [(2, 1), (3, 0)])
def test_also_possible_counts_only_where_it_is_short(tmp_path: Path, others: int, counts: int) -> None:
    also = [other("stribeck", "joint_2"), *(other("presliding", f"joint_{n}") for n in range(others))]
    said = finding(1, "nonlinear_viscous", "joint_2", also_possible=also)
    found = score(benchmark(tmp_path, {**PERFECT, "case_0001": [said]}))
    assert found["visible"]["top1"] == 0
    assert found["visible"]["top1_or_also_possible"] == counts


def test_naming_clutter_is_no_false_alarm_and_inventing_it_is(tmp_path: Path) -> None:
    said = {**PERFECT, "case_0005": [finding(1, "torque_ripple", "joint_4")]}
    assert score(benchmark(tmp_path, said))["clean"]["false_alarms"] == 0
    (tmp_path / "again").mkdir()
    said["case_0004"] = [finding(1, "torque_ripple", "joint_4")]
    assert score(benchmark(tmp_path / "again", said))["clean"]["without_clutter"] == {"n": 1, "false_alarms": 1}


def test_naming_one_joint_of_what_all_have_is_not_right_and_not_wrong(tmp_path: Path) -> None:
    found = score(benchmark(tmp_path, {**PERFECT, "case_0003": [finding(1, "torque_delay", "joint_5")]}))
    assert found["pairs"] == {"n": 1, "both": 0, "exact": 0, "one": 0}
    assert found["wrong_names"]["names"] == 0


def test_a_pair_of_which_one_is_named_is_half_found(tmp_path: Path) -> None:
    found = score(benchmark(tmp_path, {**PERFECT, "case_0003": [finding(1, "stribeck", "joint_1")]}))
    assert found["pairs"] == {"n": 1, "both": 0, "exact": 0, "one": 1}


def test_cases_without_a_result_are_told_and_not_counted(tmp_path: Path) -> None:
    found = score(benchmark(tmp_path, {"case_0001": PERFECT["case_0001"]}))
    assert (found["cases"], found["missing"]) == (1, 4)
    (tmp_path / "results" / "case_0001.json").unlink()
    with pytest.raises(BadInput, match="evaluated"):
        score(tmp_path)


def _one(out: Path, truth: dict[str, Any], *said: dict[str, Any], **answer: Any) -> dict[str, Any]:
    """The score of one case in which `truth` is hidden and `said` are the findings."""
    case = {"case": "case_0001", "robot": "torso8", "effects": [truth], "clutter": [], **answer}
    write_answers(out, 1, [{**case, "effects": [{"visible": True, "ratio": 4.0, "parameters": {}, **truth}]}])
    (out / "results").mkdir()
    findings = [{"rank": n + 1, "held_out": None, **each} for n, each in enumerate(said)]
    record = {"case": "case_0001", "seconds": 1.0, "error": None, "discrepancy": {"findings": findings}}
    (out / "results" / "case_0001.json").write_text(json.dumps(record), encoding="utf-8")
    return score(out)


PLACES = [
    {"sensor": "wrist", "axis": "fx"}, {"band": "A_left"}, {"base": True}, {"link": "tool"}, {"joint": "joint_2"},
    {"log": "val_1"},
]  # fmt: skip


@pytest.mark.parametrize("where", PLACES, ids=lambda where: next(iter(where)))
def test_every_sort_of_place_is_right_where_it_is_the_same_and_wrong_elsewhere(tmp_path: Path, where) -> None:
    for folder in ("same", "other"):
        (tmp_path / folder).mkdir()
    truth = {"effect": "something", "where": where}
    assert _one(tmp_path / "same", truth, dict(truth))["visible"]["top1"] == 1
    last = list(where)[-1]
    other = {"effect": "something", "where": {**where, last: "another"}}
    found = _one(tmp_path / "other", truth, other)
    assert found["visible"]["top1"] == 0
    assert found["wrong_names"]["names"] == 1


def test_another_axis_of_the_sensor_is_the_wrong_place_and_one_of_all_axes_is_neither(tmp_path: Path) -> None:
    for folder in ("one", "all"):
        (tmp_path / folder).mkdir()
    said = {"effect": "ft_drift", "where": {"sensor": "wrist", "axis": "my"}}
    one = _one(tmp_path / "one", {"effect": "ft_drift", "where": {"sensor": "wrist", "axis": "mx"}}, said)
    assert (one["visible"]["top1"], one["wrong_names"]["names"]) == (0, 1)
    every = _one(tmp_path / "all", {"effect": "ft_drift", "where": {"sensor": "wrist", "axis": "all"}}, said)
    assert (every["visible"]["top1"], every["wrong_names"]["names"]) == (0, 0)


def test_links_that_are_fixed_to_each_other_are_one_place(tmp_path: Path) -> None:
    truth = {"effect": "payload", "where": {"link": "tool"}}
    said = {"effect": "payload", "where": {"link": "flange"}}
    assert _one(tmp_path, truth, said, rigid=[["flange", "wrist_ft", "tool"]])["visible"]["top1"] == 1


@pytest.mark.parametrize(
    ("where", "right"),
    [
        ({"band": "chest to BODY"}, 1), ({"link": "chest"}, 1), ({"link": "head"}, 1), ({"band": "A_left"}, 0),
        ({"link": "l_forearm"}, 0), ({"joint": "torso_yaw"}, 1), ({"joint": "l_elbow_pitch"}, 0),
    ],
)  # fmt: skip
def test_a_band_that_has_no_name_is_known_by_its_ends(tmp_path: Path, where, right: int) -> None:
    truth = {
        "effect": "extra_band",
        "where": {"band": "extra"},
        "parameters": {"ends": ["chest", "BODY"], "joints": ["torso_yaw"]},
    }
    said = {"effect": "extra_band", "where": where}
    found = _one(tmp_path, truth, said, bands={"A_left": {}}, rigid=[["chest", "computer", "head"]])
    assert found["visible"]["top1"] == right


def test_undecided_is_neither_a_false_alarm_nor_a_hit(tmp_path: Path) -> None:
    out = benchmark(tmp_path, {answer["case"]: [] for answer in ANSWERS})
    silent = score(out)
    for path in (out / "results").iterdir():
        record = json.loads(path.read_text(encoding="utf-8"))
        record["discrepancy"] |= {"verdict": "undecided", "left": "open", "reason": "cannot judge: 1.2 of 5 s"}
        path.write_text(json.dumps(record), encoding="utf-8")
    assert score(out) == silent
    assert silent["clean"]["false_alarms"] == silent["all"]["top1"] == 0
