"""A planned motion can be taken away as a table, and the results say which file is whose."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import replace

import numpy as np
import pytest

from exogauge.findings.planned_motion import Apart, PlannedMotion, Sweep
from exogauge.findings.result import Discrepancy
from exogauge.studies.results.discrepancy_results import discrepancy_entry, motion_table, planned_files
from exogauge.studies.results.plain_values import finite
from exogauge.studies.results.schema.discrepancy import RivalApart
from exogauge.studies.words.motion_sentences import planned_sentence

TOLD = Apart("presliding", "torso_pitch", 0.12, 0.64, 1.5, 52.0, 13.0, 7.7, 10.0, 600.0)


def plan(joint: str) -> PlannedMotion:
    sweep = Sweep("sine", 0.3, 0.1, 0.0, 0.47, 20.0, 4.0)
    q = np.zeros((200, 2))
    q[:, 1] = sweep.position(50.0)[:200]
    return PlannedMotion(
        joint,
        "",
        (0.0, 0.0),
        sweep,
        "rad",
        2,
        40.0,
        (TOLD,),
        True,
        np.arange(200) / 50.0,
        ("torso_yaw", joint),
        q,
        ("torque",),
        ("touch", "balance"),
    )


@pytest.fixture(scope="module")
def planned(discrepancy: Discrepancy) -> Discrepancy:
    first, second = discrepancy.findings
    one, two = plan("torso_pitch"), plan("r_elbow")
    return replace(
        discrepancy,
        findings=(
            replace(first, apart=(TOLD,), plans=(one,)),
            replace(second, apart=(TOLD,), plans=(two,)),
        ),
    )


def test_every_file_belongs_to_one_finding(planned: Discrepancy) -> None:
    entry = json.loads(json.dumps(finite(discrepancy_entry(planned)), allow_nan=False))
    named = {one["joint"]: one["file"] for found in entry["findings"] for one in found["planned"]}
    written = {motion.joint: f"{name}.csv" for name, motion in planned_files(planned)}
    assert named == written == {"torso_pitch": "planned_motion_1.csv", "r_elbow": "planned_motion_2.csv"}
    assert entry["findings"][0]["apart"][0]["left_then"] == 0.64
    for told in entry["findings"][0]["apart"]:
        RivalApart.model_validate(told)  # a key too many failed the whole evaluation, at its end


def test_the_table_holds_every_joint_over_time(planned: Discrepancy) -> None:
    (_, motion), _ = planned_files(planned)
    rows = list(csv.reader(io.StringIO(motion_table(motion).decode())))
    assert rows[0] == ["t", "q.torso_yaw", "q.torso_pitch"]
    table = np.array(rows[1:], dtype=float)
    assert table[:, 0] == pytest.approx(motion.time, abs=1e-5)
    assert table[:, 1:] == pytest.approx(motion.q, abs=1e-5)


def test_the_sentence_says_what_to_do_what_for_and_what_is_not_known() -> None:
    said = planned_sentence(plan("torso_pitch")).replace("\u00a0", " ")
    assert "Swing torso_pitch by ±0.30 rad" in said
    assert "12 % was left in these logs, 64 % would be" in said
    assert "presliding friction" in said
    assert "for 40 s" in said
    assert "stay still" in said
    assert "Every joint's own limits and every motor's torque are kept" in said
    assert "touch itself and whether the robot keeps its balance is not known" in said


def test_nothing_planned_leaves_no_file(discrepancy: Discrepancy) -> None:
    assert list(planned_files(discrepancy)) == []
    assert list(planned_files(None)) == []
    assert all(each["planned"] == [] for each in discrepancy_entry(discrepancy)["findings"])
