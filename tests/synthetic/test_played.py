"""A planned motion of a file, played by the sample's robot."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import pyarrow.parquet as pq
import pytest
import yaml

from exogauge.errors import BadInput, BadMotion
from exogauge.synthetic import write_sample
from exogauge.synthetic.disturbances import chosen
from exogauge.synthetic.log_plans import LogPlan
from exogauge.synthetic.motion import KNOT_RATE_HZ, LEAD_S
from exogauge.synthetic.played import read_motions, read_played
from exogauge.synthetic.robot_facts import ANKLE_HEIGHT, HOME, JOINT_NAMES
from exogauge.synthetic.study import write_study
from exogauge.synthetic.variation import Variation

SECONDS, BENT = 4.0, 0.5
Change = Callable[[dict[str, np.ndarray]], None]


def bow(path: Path, change: Change = lambda columns: None) -> Path:
    """A bow of the trunk out of home and back, at 200 Hz; joints that do not move are not named."""
    t = np.arange(round(SECONDS * 200) + 1) / 200.0
    columns = {"t": t, "q.torso_pitch": BENT * np.sin(np.pi * np.clip((t - 0.5) / 3.0, 0.0, 1.0)) ** 4}
    change(columns)
    rows = np.column_stack(list(columns.values()))
    path.write_text("\n".join([",".join(columns), *(",".join(f"{x:.8f}" for x in row) for row in rows)]) + "\n")
    return path


def squat_with_one_leg(columns: dict[str, np.ndarray]) -> None:
    shape = columns["q.torso_pitch"] / BENT
    for name, share in (("hip_pitch", -0.3), ("knee_pitch", 0.6), ("ankle_pitch", -0.3)):
        columns[f"q.r_{name}"] = HOME[f"r_{name}"] + share * shape


def test_a_plan_that_lifts_a_foot_is_refused_with_the_foot_and_the_time(tmp_path: Path) -> None:
    def lift(columns: dict[str, np.ndarray]) -> None:
        columns["stands.l_foot"] = ((columns["t"] < 1.5) | (columns["t"] > 2.0)) * 1.0
        columns["stands.r_foot"] = np.ones_like(columns["t"])

    with pytest.raises(BadMotion) as told:
        read_played(bow(tmp_path / "lift.csv", lift))
    fault = told.value.faults[0]
    assert (fault.rule, fault.row, fault.column) == ("foot_lifts", 301, "stands.l_foot")
    assert "lifts l_foot from 1.50 s on" in str(told.value)
    still = read_played(bow(tmp_path / "still.csv", lambda c: c.update({"stands.l_foot": np.ones_like(c["t"])})))
    assert still.angles == pytest.approx(read_played(bow(tmp_path / "bow.csv")).angles)


def test_a_run_that_does_not_differ_is_the_files_own_motion(tmp_path: Path, planner: mujoco.MjModel) -> None:
    given = read_played(bow(tmp_path / "bow.csv"))
    plan = given.plan(np.random.default_rng(1), np.random.default_rng(2), None, planner)
    lead = round(LEAD_S * KNOT_RATE_HZ)
    np.testing.assert_allclose(plan.angles[lead:], given.angles, atol=1e-9)
    assert np.abs(plan.angles[0] - given.angles[0]).max() > 0.1, "it arrives out of a motion"
    assert given.angles[:, JOINT_NAMES.index("torso_pitch")].max() == pytest.approx(BENT, abs=1e-4)
    assert given.angles[0, JOINT_NAMES.index("l_knee_pitch")] == HOME["l_knee_pitch"]


def test_a_run_that_differs_keeps_both_feet(tmp_path: Path, planner: mujoco.MjModel) -> None:
    varied = Variation(smooth=0.02, offset=0.0, amplitude_std=0.05, timing=0.02, seed=1, run="bow_plain_1")
    given = read_played(bow(tmp_path / "bow.csv"))
    plan = given.plan(np.random.default_rng(1), np.random.default_rng(2), varied, planner)
    data, feet = mujoco.MjData(planner), []
    quaternion = np.zeros(4)
    for angles, base, R in zip(plan.angles, plan.base, plan.R_base, strict=True):
        mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(R).ravel())
        data.qpos[:] = np.concatenate([base, quaternion, angles])
        mujoco.mj_kinematics(planner, data)
        feet.append([data.body(foot).xpos.copy() for foot in ("l_foot", "r_foot")])
    places = np.array(feet)
    assert np.abs(places - places[-1]).max() < 1e-9
    assert places[..., 2] == pytest.approx(ANKLE_HEIGHT)
    off = plan.angles[round(LEAD_S * KNOT_RATE_HZ) :] - given.angles
    rms = np.sqrt(np.mean(off[:, JOINT_NAMES.index("l_shoulder_pitch")] ** 2))
    assert rms == pytest.approx(0.02 / np.sqrt(2.0), rel=0.2)


@pytest.mark.parametrize(
    ("change", "rule", "where"),
    [
        (squat_with_one_leg, "foot_moves", None),
        (lambda c: c.update({"q.torso_pitch": np.degrees(c["q.torso_pitch"])}), "beyond_bound", "q.torso_pitch"),
        (lambda c: c["t"].__setitem__(7, c["t"][5]), "bad_time", "t"),
        (lambda c: c["q.torso_pitch"].__setitem__(9, np.nan), "not_a_number", "q.torso_pitch"),
        (lambda c: c.update({"t": c["t"] / 100.0}), "bad_duration", "t"),
        (lambda c: c.update({"q.elbow": c.pop("q.torso_pitch")}), "missing_column", "q.torso_pitch"),
        (lambda c: c.update({"time": c.pop("t")}), "missing_column", "t"),
    ],
)
def test_what_cannot_be_played_is_refused_with_its_place(
    tmp_path: Path, change: Change, rule: str, where: str | None
) -> None:
    with pytest.raises(BadMotion) as refused:
        read_motions([bow(tmp_path / "bow.csv", change)])
    (fault,) = refused.value.faults
    assert (fault.rule, fault.column, fault.file) == (rule, where, "bow.csv")
    assert fault.advice


def test_one_name_for_two_motions_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    paths = [bow(tmp_path / "bow.csv"), bow(tmp_path / "a" / "bow.csv")]
    with pytest.raises(BadMotion, match="one name"):
        read_motions(paths)


@pytest.mark.slow
def test_a_played_motion_is_logged_without_and_with_the_suit(tmp_path: Path) -> None:
    (given,) = read_motions([bow(tmp_path / "bow.csv")])
    out = tmp_path / "out"
    out.mkdir()
    logs = tuple(
        LogPlan(f"bow_{worn or 'plain'}_1", role, "bow", given.duration_s, worn, repeats=True)
        for worn, role in ((None, "without_device"), ("normal", "with_device"))
    )
    write_study(out, 3, suit="normal", logs=logs, played=[given], disturbed=chosen("lab"))
    study = yaml.safe_load((out / "study.yaml").read_text())
    assert study["plans"] == ["plans/bow.csv"]
    assert (out / "plans/bow.csv").read_bytes() == (tmp_path / "bow.csv").read_bytes()
    assert [entry["motion"] for entry in study["logs"]] == ["bow", "bow"]
    planned = given.angles[:, JOINT_NAMES.index("torso_pitch")]
    for entry in study["logs"]:
        followed = pq.read_table(out / entry["file"])["q.torso_pitch"].to_numpy()
        assert followed.max() == pytest.approx(planned.max(), rel=0.06)
    truth = pq.read_table(out / "truth/bow_normal_1.parquet")
    assert truth["torso_pitch"].to_numpy().min() < -1.0, "the suit pulls against a bow"
    assert "amplitude" in json.loads((out / "truth.json").read_text())["session"]["logs"]["bow_plain_1"]


@pytest.mark.slow
def test_a_motion_too_wild_for_the_robot_is_told_with_its_moment(tmp_path: Path) -> None:
    def leans(columns: dict[str, np.ndarray]) -> None:
        shape = columns["q.torso_pitch"] / BENT
        for side in "lr":
            columns[f"q.{side}_ankle_pitch"] = HOME[f"{side}_ankle_pitch"] + 0.6 * shape

    (given,) = read_motions([bow(tmp_path / "lean.csv", leans)])
    log = LogPlan("lean_plain_1", "without_device", "lean", given.duration_s, repeats=True)
    with pytest.raises(BadInput, match=r"fell after \d\.\d s, in lean_plain_1"):
        write_study(tmp_path, 3, suit="none", logs=(log,), played=[given])


def test_a_payload_plays_no_motion(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from exogauge.cli import main

    code = main(["sample", str(tmp_path / "out"), "--seed", "1", "--payload", "--motion", str(bow(tmp_path / "b.csv"))])
    assert code != 0
    assert "plays no motion" in capsys.readouterr().err


def test_a_sample_refuses_a_motion_before_it_writes(tmp_path: Path) -> None:
    with pytest.raises(BadMotion):
        write_sample(tmp_path / "out", 1, motions=[tmp_path / "none.csv"])
    assert not (tmp_path / "out").exists()
