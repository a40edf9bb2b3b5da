"""results.json, the tables and the series say of a device what the evaluation found, under the contract's keys."""

from __future__ import annotations

import csv
import dataclasses
import io
import json
import math
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from exogauge.devices.result import CrossCheck, Estimate, StiffnessResult
from exogauge.identification.result import Identification
from exogauge.robots.description import Declared
from exogauge.studies.evaluate import write
from exogauge.studies.intake.open import open_study
from exogauge.studies.results.document import Evaluation, to_json
from exogauge.studies.results.plain_values import finite
from exogauge.studies.results.support_results import (
    cross_checks,
    doubted,
    main_joints,
    stiffness_details,
    stiffness_entries,
    stiffness_table,
    support_entries,
    support_table,
)
from exogauge.studies.series.write import write_series
from exogauge.studies.words.doubt_words import doubt_sources
from exogauge.support.result import SupportResult


def entry(
    support: SupportResult, device: str = "Normal suit", motion: str = "bend", joint: str = "torso_pitch"
) -> dict:
    found = json.loads(to_json({"support": finite(support_entries(support))}))["support"]
    (chosen,) = (e for e in found if (e["device"], e["motion"], e["joint"]) == (device, motion, joint))
    return chosen


def rows(table: bytes) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(table.decode())))


def test_there_is_one_entry_per_device_motion_and_joint_the_own_device_first(support: SupportResult) -> None:
    found = support_entries(support)
    assert len({(e["device"], e["motion"], e["joint"]) for e in found}) == len(found) == 12
    assert [e["device"] for e in found[:6]] == ["Normal suit"] * 6


def test_every_number_stands_with_its_std_and_unit(support: SupportResult) -> None:
    found = entry(support)
    joint = next(each for each in support.joints if (each.motion, each.joint) == ("bend", "torso_pitch"))
    low, high = found["peak"].pop("interval_95")
    assert found["peak"] == {
        "value": joint.by["a"].peak.value, "std": joint.by["a"].peak.std, "unit": "N·m", "approach": "A",
        "as_good": ["A", "B"], "budget": [],
    }  # fmt: skip
    assert 0.5 * (low + high) == pytest.approx(joint.by["a"].peak.value)
    assert 0.5 * (high - low) == pytest.approx(1.96 * joint.by["a"].peak.std, rel=1e-3)
    assert found["integral"]["unit"] == "N·m·s"
    assert set(found["approaches"]) == {"A", "B", "paired", "prior", "band_model"}
    assert found["approaches"]["B"]["spread"] == joint.spread["b"]
    assert found["approaches"]["band_model"]["spread"] is None
    assert [part["phase"] for part in found["phases"]] == ["standing", "lowering", "holding", "raising"]
    assert found["phases"][2]["approaches"]["A"]["mean"]["value"] == joint.phases[2].by["a"].mean.value
    assert (found["rmse_a"], found["rmse_b"], found["rmse_prior"]) == tuple(joint.rmse[k] for k in ("a", "b", "prior"))
    assert found["null"] == {"a": 0.123, "b": 0.321, "paired": 0.213}


def test_a_number_stands_with_what_its_doubt_is_made_of_the_largest_part_first() -> None:
    number = Estimate(5.0, 0.5, "N·m", {"scatter": 0.3, "kt_drift": 0.4})
    assert doubted(number)["budget"] == [{"source": "kt_drift", "std": 0.4}, {"source": "scatter", "std": 0.3}]


def test_every_source_of_doubt_is_told_in_words_with_what_would_make_it_smaller() -> None:
    declared = {each.name for each in dataclasses.fields(Declared)} - {
        "torque_zero_of",
        "zeros_taken",
        "defaulted",
    }
    declared = {name.removesuffix("_force").removesuffix("_moment") for name in declared}
    assert set(doubt_sources()) >= declared | {"via_points", "donning", "scatter", "robot", "null_test", "at_rest"}
    assert all(said["advice"].endswith(".") for said in doubt_sources().values())


def test_what_acts_on_a_joint_that_slides_is_a_force(support: SupportResult) -> None:
    turning = support_entries(support)
    sliding = support_entries(
        dataclasses.replace(support, joints=tuple(dataclasses.replace(each, slides=True) for each in support.joints))
    )
    assert {each["unit"] for each in turning} == {"N·m"}
    assert {each["unit"] for each in sliding} == {"N"}
    told = [each["motion_equality"]["units"] for each in sliding if each["motion_equality"]]
    assert told
    assert all(each == {"q_rms": "m", "dq_rms": "m/s"} for each in told)


def test_motion_equality_pools_the_trials_and_takes_the_worst_word(support: SupportResult) -> None:
    doubtful = tuple(
        dataclasses.replace(
            trial, equality=tuple(dataclasses.replace(each, verdict="doubtful") for each in trial.equality)
        )
        if trial.log == "bend_normal_2"
        else trial
        for trial in support.trials
    )
    found = entry(dataclasses.replace(support, trials=doubtful))["motion_equality"]
    assert found["verdict"] == "doubtful"
    assert found["q_rms"] == pytest.approx(math.sqrt((0.002**2 + 0.004**2) / 2))
    assert found["lag_s"] == pytest.approx(0.024)
    assert [each["reference"] for each in found["trials"]] == ["bend_plain_1", "bend_plain_2"]


def test_without_a_reference_the_numbers_are_those_of_b(support: SupportResult) -> None:
    alone = dataclasses.replace(
        support,
        trials=tuple(
            dataclasses.replace(
                each, reference=None, support_a=None, support_a_std=None, low_a=None, high_a=None, equality=()
            )
            for each in support.trials
        ),
        joints=tuple(
            dataclasses.replace(
                each, by={k: v for k, v in each.by.items() if k not in ("a", "paired")},
                rmse={"b": 0.3, "prior": math.nan}, rmse_steady={}, null={"b": 0.3},
                references=(), equality=(), lag_s=(),
            )
            for each in support.joints
        ),
    )  # fmt: skip
    found = entry(alone)
    assert found["peak"]["approach"] == "B"
    assert found["motion_equality"] is None
    assert found["rmse_a"] is None
    assert found["rmse_prior"] is None
    assert found["rmse_steady"] == {"a": None, "b": None, "paired": None, "prior": None}


def test_the_main_joints_are_those_the_device_acts_on(support: SupportResult) -> None:
    assert main_joints(support, "bend") == ("torso_pitch",)
    assert main_joints(support, "twist") == ("torso_yaw",)
    assert entry(support)["main"]
    assert not entry(support, joint="r_elbow")["main"]


def test_a_joint_that_stands_still_is_no_main_joint(support: SupportResult) -> None:
    held = tuple(
        dataclasses.replace(each, rest_share=1.0) if each.joint == "torso_pitch" else each for each in support.joints
    )
    assert "torso_pitch" not in main_joints(dataclasses.replace(support, joints=held), "bend")
    still = tuple(dataclasses.replace(each, rest_share=1.0) for each in support.joints)
    assert main_joints(dataclasses.replace(support, joints=still), "bend") == ("torso_pitch",)


def test_stiffness_entries_hold_value_interval_truth_and_error(stiffness: tuple[StiffnessResult, ...]) -> None:
    found = finite(stiffness_entries(stiffness))
    first, unknown = found[0], found[2]
    assert (first["device"], first["approach"], first["band"], first["group"]) == ("Normal suit", "A", "A_left", "A")
    assert first["stiffness_n_per_m"] == {"value": 0.985 * 197.8, "std": 2.9, "unit": "N/m"}
    assert first["interval_95"]["natural_length_m"] == [0.6035, 0.6211]
    assert first["error_percent"] == pytest.approx(-1.5)
    assert unknown["stiffness_n_per_m"]["std"] is None
    assert unknown["truth_n_per_m"] is None
    assert unknown["note"].startswith("B_left pulls nowhere")
    details = finite(stiffness_details(stiffness))
    assert [each["approach"] for each in details] == ["A", "B", "prior"] * 2
    assert details[0]["correlation"][0][1] == 0.97


@pytest.mark.parametrize(("stds", "chosen"), [((60.0, 35.0), "A"), ((60.0, 20.0), "B"), ((20.0, 35.0), "A")])
def test_the_headline_stiffness_is_the_best_known_for_its_size(
    stiffness: tuple[StiffnessResult, ...], stds: tuple[float, float], chosen: str
) -> None:
    """190 by A, 95 by B: a doubt of 35 N/m is more of the smaller one than 60 N/m are of the other."""
    made = []
    for each, value, std in zip(stiffness[:2], (190.0, 95.0), stds, strict=True):
        own = [dataclasses.replace(b, stiffness=Estimate(value, std, "N/m"), identifiable=True) for b in each.bands]
        made.append(dataclasses.replace(each, bands=tuple(own)))
    told = {one["approach"] for one in stiffness_entries(made) if one["headline"]}
    assert told == {chosen}


def test_the_tables_hold_every_number(support: SupportResult, stiffness: tuple[StiffnessResult, ...]) -> None:
    found = rows(support_table(support))
    assert len(found) == 12 * (5 + 4 * 5)  # whole motion and four phases, by five approaches
    whole = [row for row in found if row["phase"] == "" and row["joint"] == "torso_pitch" and row["approach"] == "A"]
    assert float(whole[0]["rmse"]) == entry(support)["rmse_a"]
    assert float(whole[0]["peak"]) == entry(support)["peak"]["value"]
    bands = rows(stiffness_table(stiffness))
    assert len(bands) == 18
    assert float(bands[0]["stiffness_n_per_m"]) == pytest.approx(0.985 * 197.8)
    assert bands[2]["identifiable"] == "false"
    assert bands[2]["truth_n_per_m"] == ""


def test_a_reader_of_the_series_finds_the_stated_rmse(support: SupportResult, tmp_path: Path) -> None:
    trial = support.trials[0]
    write_series(trial.prediction, tmp_path / "worn.parquet", trial)
    table = pq.read_table(tmp_path / "worn.parquet")
    model = np.asarray(table["support_band_model.torso_pitch"])
    for approach in ("a", "b", "prior"):
        error = np.asarray(table[f"support_{approach}.torso_pitch"]) - model
        assert math.sqrt(np.mean(error**2)) == pytest.approx(entry(support)[f"rmse_{approach}"], rel=1e-12)


def test_series_of_a_worn_log_hold_phase_bands_and_the_interval_at_rest(support: SupportResult, tmp_path: Path) -> None:
    trial = support.trials[0]
    write_series(trial.prediction, tmp_path / "worn.parquet", trial)
    table = pq.read_table(tmp_path / "worn.parquet")
    assert table["phase"].to_pylist()[:: 100 * 5] == ["standing", "lowering", "holding", "raising", "standing"]
    width = np.asarray(table["support_b_high.torso_pitch"]) - np.asarray(table["support_b_low.torso_pitch"])
    rest = np.asarray(table["support_rest.torso_pitch"])
    assert width[rest] == pytest.approx(3.4)
    assert np.isnan(width[~rest]).all()
    assert table.schema.field("band.A_left.tension").metadata == {b"unit": b"N"}
    assert np.asarray(table["band.A_left.length"]).max() == pytest.approx(0.67)
    assert not np.asarray(table["support_compared.torso_pitch"]).all()
    assert table.schema.metadata[b"device"] == b"Normal suit"
    assert "measured.tau.torso_pitch" in table.column_names


def test_series_without_reference_or_band_values_have_no_such_columns(support: SupportResult, tmp_path: Path) -> None:
    trial = dataclasses.replace(
        support.trials[0],
        support_a=None,
        support_a_std=None,
        low_a=None,
        high_a=None,
        reference=None,
        band_model=None,
        tension={},
    )
    write_series(trial.prediction, tmp_path / "worn.parquet", trial)
    names = pq.read_table(tmp_path / "worn.parquet").column_names
    assert not [name for name in names if name.startswith(("support_a", "support_band_model", "support_compared"))]
    assert "band.A_left.length" in names
    assert "band.A_left.tension" not in names


@pytest.mark.slow
def test_an_evaluation_with_a_device_leaves_every_file_that_it_names(
    pristine: Path,
    identification: Identification,
    support: SupportResult,
    stiffness: tuple[StiffnessResult, ...],
    tmp_path: Path,
) -> None:
    with open_study(pristine) as study:
        whole = Evaluation(
            study.name, study.robot, study.settings, study.steps, study.bundle.inputs, [], identification, [], {},
            support, stiffness,
        )  # fmt: skip
        write(study, whole, tmp_path / "out")
    found = json.loads((tmp_path / "out" / "results.json").read_text(), parse_constant=pytest.fail)
    assert {"support", "stiffness", "series.id_1", "series.bend_modified_2"} <= found["files"].keys()
    assert all((tmp_path / "out" / name).is_file() for name in found["files"].values())
    assert len(found["support"]) == 12
    assert len(found["stiffness"]) == 18
    assert len(found["stiffness_details"]) == 6
    (told,) = [each for each in found["notices"] if each["code"] == "touched"]
    assert (told["names"], told["numbers"]) == (["bend_normal_1"], [1.0, 2.0])
    assert told["sentence"].startswith("bend_normal_1, from 1.00 to 2.00 s: something touched the robot.")
    assert found["warnings"] == [each["sentence"] for each in found["notices"]]


def test_what_is_not_decided_has_no_headline_and_no_end_to_its_doubt(support: SupportResult) -> None:
    """A fit that is spoiled, labels that are exchanged: peaks stood there with their doubt as if nothing was wrong."""
    found, before = entry(support.with_nothing_decided({each.device for each in support.joints})), entry(support)
    assert before["peak"] is not None
    assert [found[name] for name in ("peak", "mean", "integral")] == [None] * 3
    told = [found["approaches"][name] for name in ("A", "B", "paired", "prior")]
    told += [part["approaches"][name] for part in found["phases"] for name in ("A", "B", "paired", "prior")]
    assert [each[name]["std"] for each in told for name in ("peak", "mean", "integral")] == [None] * (3 * len(told))
    assert {ends for each in told[:4] for ends in each["peak"]["interval_95"]} <= {None}
    assert {part["best"] for part in found["phases"]} == {None}
    assert found["approaches"]["band_model"] == before["approaches"]["band_model"]


def test_of_checks_of_the_same_parts_each_unit_stands_once_by_the_worst(stiffness: tuple[StiffnessResult, ...]) -> None:
    """What fails by natural lengths stood behind a stiffness that agrees."""
    parts = "strokes", stiffness[0].bands[0].group, ("lengthening", "shortening")
    checks = (
        CrossCheck(*parts, -60.0, 40.0, 3.9),
        CrossCheck(*parts, -0.004, 0.002, 3.9, "m"),
        CrossCheck(*parts, -0.006, 0.001, 3.9, "m"),
    )
    found = cross_checks([dataclasses.replace(stiffness[0], cross_checks=checks)])
    assert [(each["unit"], each["difference"], each["agrees"]) for each in found] == [
        ("N/m", -60.0, True),
        ("m", -0.006, False),
    ]
