"""A planned motion is judged by MuJoCo, between the nodes."""

from __future__ import annotations

import gzip
import re
import shutil
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import yaml
from tests.motion.by_mujoco import ByMuJoCo
from tests.motion.plans import SOON, at, bend

from exogauge.criteria.motion_plan import USUAL
from exogauge.errors import BadMotion
from exogauge.motion.files import open_motion
from exogauge.motion.person import Person, person_of
from exogauge.motion.plan.export import exported, sheet
from exogauge.motion.plan.frame_by_frame import frame_by_frame
from exogauge.motion.plan.judge import judge
from exogauge.motion.plan.outcome import margins, slow, summarise
from exogauge.motion.plan.retarget import ask
from exogauge.motion.plan.solve import Round, plan
from exogauge.motion.plan.spline import through
from exogauge.motion.plan.within import plan_within
from exogauge.motion.robot_file import load_motion_robot
from exogauge.robots.moving.robot import MotionRobot

JVRC = Path(__file__).parents[3] / "shared/data/model_jvrc1/jvrc_description/urdf/jvrc1.urdf"
CAPTURES = Path(__file__).parents[3] / "shared" / "data" / "cmu_mocap_bend_twist"


@pytest.mark.slow
def test_a_bend_keeps_every_bound_as_mujoco_sees_it(robot: MotionRobot, bent) -> None:
    asked, planned = bent
    rate = 1000.0
    seen = ByMuJoCo(robot, planned.spline, rate)
    assert seen.inside.min() >= 0.015
    assert np.abs(seen.feet - seen.feet[0]).max() <= 1e-4
    upper = np.array(robot.beyond("thorax") + robot.torso)
    assert (np.abs(seen.torque[:, upper]) <= robot.limits.torque[upper]).all()
    judged = judge(robot, planned.spline, asked.place[0], rate=rate, planned=planned)
    assert judged.broken == ()
    assert judged.inside[1:-1] == pytest.approx(seen.inside, abs=2e-4)
    assert judged.torque[1:-1, upper] == pytest.approx(seen.torque[:, upper], abs=0.05)
    given = planned.spline.at_nodes()[0]
    off = np.degrees(given - asked.q)[:, robot.base + np.array(robot.torso)]
    assert np.sqrt(np.mean(off**2, axis=0)).max() <= 0.2
    assert np.abs(off).max() <= 1.0


@pytest.mark.slow
def test_stretches_that_are_planned_one_by_one_are_one_motion(robot: MotionRobot, bent) -> None:
    asked, planned = bent
    parts = list[int]()
    short = replace(USUAL, stretch_s=0.5)
    joined = plan(robot, asked, short, report=lambda now: parts.append(now.part))
    assert set(parts) == {0, 1, 2}
    assert judge(robot, joined.spline, asked.place[0], planned=joined, rate=1000.0).broken == ()
    torso = robot.base + np.array(robot.torso)
    apart = joined.spline.at_nodes()[0] - planned.spline.at_nodes()[0]
    assert np.degrees(np.abs(apart[:, torso]).max()) < 0.3


@pytest.mark.slow
def test_acceleration_and_jerk_are_held_between_nodes_too(robot: MotionRobot, brief) -> None:
    asked, planned = brief
    seen = judge(robot, planned.spline, asked.place[0], planned=planned, rate=1000.0)
    moved = at(robot, "l_shoulder_pitch") - robot.base
    tops = [np.abs(planned.spline.at(seen.time)[2][:, robot.base + moved]).max(),
            np.abs(np.diff(planned.spline.control[:, robot.base + moved], 3)).max() / asked.step**3]  # fmt: skip
    slow = robot.limits.acceleration.copy(), robot.jerk.copy()
    for bound, top in zip(slow, tops, strict=True):
        bound[moved] = 0.7 * top
    lazy = replace(robot, limits=replace(robot.limits, acceleration=slow[0], jerk=slow[1]))
    told = judge(lazy, planned.spline, asked.place[0], planned=planned, rate=1000.0).broken
    assert [line.split(":")[0] for line in told] == ["acceleration of l_shoulder_pitch", "jerk of l_shoulder_pitch"]
    again = plan(lazy, asked)
    assert judge(lazy, again.spline, asked.place[0], planned=again, rate=1000.0).broken == ()


@pytest.mark.slow
def test_rounds_settle_where_torques_of_waist_and_arms_bind(robot: MotionRobot) -> None:
    """Talos' waist and arms: a torque that was left out was broken, at one node further in every round: 13 of them. Its
    knees, which the feet spared by sharing unevenly, took 120 % where a table has them share as evenly as they can."""
    weaker = robot.limits.torque.copy()
    for k, joint in enumerate(robot.joints):
        weaker[k] *= 0.35 if "shoulder" in joint or "torso" in joint else 1.0
    own = replace(robot, limits=replace(robot.limits, torque=weaker))
    asked = bend(own, 1.0, 1.5)
    planned = plan(own, asked)
    seen = judge(own, planned.spline, asked.place[0], planned=planned)
    assert seen.broken == ()
    assert seen.most["torque"][own.joints.index("torso_pitch")] > 0.95
    assert planned.rounds <= 10  # 8
    legs = np.concatenate([own.leg(foot) for foot in (0, 1)]) - own.base
    evenly = judge(own, planned.spline, asked.place[0]).torque
    assert (np.abs(seen.torque - evenly) / own.limits.torque)[:, legs].max() < 0.02


def test_what_is_asked_alone_would_fall(robot: MotionRobot, bent) -> None:
    """The plan is what keeps the balance: the same bend with the pelvis where it is asked presses outside the soles."""
    asked, planned = bent
    alone = through(asked.q, asked.step)
    assert judge(robot, alone, asked.place[0], planned=planned).inside.min() < 0.0


@pytest.mark.slow
def test_a_joint_goes_no_further_than_it_can_and_a_weak_one_is_told(robot: MotionRobot) -> None:
    asked = bend(robot, 1.3, 2.0)
    planned = plan(robot, asked)
    pitch = planned.spline.at(np.arange(0.0, planned.spline.duration, 1e-3))[0][:, at(robot, "torso_pitch")]
    top = robot.limits.upper[robot.joints.index("torso_pitch")]
    assert top - 0.02 < pitch.max() <= top + 1e-9
    weak = robot.limits.torque.copy()
    weak[robot.joints.index("l_knee_pitch")] = 1.0
    limp = replace(robot, limits=replace(robot.limits, torque=weak))
    said = judge(limp, planned.spline, asked.place[0], planned=planned).broken
    assert any(line.startswith("torque of l_knee_pitch") for line in said)


@pytest.mark.slow
def test_a_broken_bound_is_told_with_its_size_and_by_how_much(robot: MotionRobot, bent) -> None:
    asked, planned = bent
    j = robot.joints.index("torso_pitch")
    largest = float(np.abs(judge(robot, planned.spline, asked.place[0], planned=planned).torque[:, j]).max())
    torque = robot.limits.torque.copy()
    torque[j] = 0.8 * largest
    lacking = replace(robot, limits=replace(robot.limits, torque=torque))
    (line,) = judge(lacking, planned.spline, asked.place[0], planned=planned).broken
    assert line.startswith("torque of torso_pitch: ")
    assert f"125 % of its bound {torque[j]:.4g}" in line


@pytest.mark.slow
def test_a_stretch_whose_rounds_come_no_nearer_is_given_up_and_told(robot: MotionRobot) -> None:
    asked, rounds = bend(robot, 0.9, 1.0), list[Round]()
    impatient = replace(USUAL, patience=1, nearer=0.0)  # no round is near enough
    planned, judged, _ = plan_within(robot, asked, impatient, rounds.append)
    assert len(rounds) <= 3
    assert planned.unsettled == ((0.0, pytest.approx(1.0)),)
    assert judged.broken[0].startswith("no plan that keeps every bound was found from 0.00 to 1.00 s")
    with pytest.raises(BadMotion) as told:
        plan(robot, asked, impatient, stop=lambda made: bool(made.unsettled))
    assert told.value.faults[0].rule == "not_kept"


@pytest.mark.slow
def test_what_keeps_the_trunk_from_its_angle_is_told(robot: MotionRobot) -> None:
    """Of iCub's roll 8.6° were missing, and nothing said that root and chest were as near as they may be."""
    time, still = np.linspace(0.0, 1.0, 61), np.tile(np.eye(3), (61, 1, 1))
    person = Person("bends", time, np.zeros((61, 3)), still, still, {}, 0.8)
    asked, slow = bend(robot, 0.6, 1.2), robot.limits.velocity.copy()
    slow[robot.joints.index("torso_pitch")] = 0.5
    said = []
    for own in (robot, replace(robot, limits=replace(robot.limits, velocity=slow))):
        planned, judged, _ = plan_within(own, asked, SOON)
        assert not judged.broken
        said.append(str(summarise(own, person, asked, np.zeros(1), planned, judged)["trunk torso_pitch"]))
    assert "most at" not in said[0]
    assert re.search(r"where it bears them, most at \d\.\d\d s, where velocity of torso_pitch is at 9\d %", said[1])


def test_where_the_feet_carry_next_to_nothing_no_centre_of_pressure_is_told(robot: MotionRobot) -> None:
    """The whole robot hops by .1 m in .3 s: there its weight is taken off the feet, which hold it down then."""
    asked = bend(robot, 0.0, 0.5)
    q = asked.q.copy()
    q[:, 2] += 0.05 * (1.0 - np.cos(np.linspace(0.0, 2.0 * np.pi, len(q))))
    judged = judge(robot, through(q, asked.step), asked.place[0])
    off = judged.carried < USUAL.least_weight
    assert off.any()
    assert not off.all()
    assert (np.isnan(judged.inside) == off).all()
    assert (np.isnan(judged.pressure[:, 0]) == off).all()
    said = margins(robot, judged)
    assert "the feet carry too little" in str(said["centre of pressure"])
    assert "nan" not in str(said)
    assert any(line.startswith("weight on the feet") for line in judged.broken)
    with pytest.raises(BadMotion, match="centre of pressure"):
        exported(robot, through(q, asked.step), judged, "hrpsys")
    assert sheet(robot, judged, "csv", {}, {})["margin_m"]["pressure_inside_soles"] == pytest.approx(
        judged.least_inside, abs=1e-5
    )


@pytest.mark.slow
def test_frame_by_frame_a_fast_bend_tips_over_with_its_feet_where_they_are_asked(robot: MotionRobot) -> None:
    """What it is told to be is what MuJoCo sees; slowly, the same posture by posture is a motion that can be had."""
    fast, told = frame_by_frame(robot, bend(robot, 0.9, 1.2), USUAL, 200.0)
    seen = ByMuJoCo(robot, fast.spline, 200.0)
    assert seen.inside.min() < 0.0
    assert told.inside[1:-1] == pytest.approx(seen.inside, abs=1e-3)
    assert told.outside == pytest.approx(np.mean(seen.inside < 0.0), abs=0.02)
    assert told.feet_m == pytest.approx(np.linalg.norm(seen.feet - seen.feet[0], axis=2).max(), abs=1e-6)
    assert told.feet_m < 2e-3  # what smoothing leaves
    assert any(line.startswith("centre of pressure") for line in told.broken)
    _, slowly = frame_by_frame(robot, bend(robot, 0.5, 8.0), USUAL, 200.0)
    assert slowly.broken == ()
    assert slowly.q[:, at(robot, "torso_pitch")].max() == pytest.approx(0.5, abs=0.005)


@pytest.mark.slow
def test_frame_by_frame_keeps_joints_in_their_range_and_the_feet_in_place_as_long_as_others_can_yield(
    robot: MotionRobot,
) -> None:
    """Knees that are asked through their end: the pelvis stays lower instead, and no foot leaves its place."""
    asked = bend(robot, 0.2, 4.0)
    asked.q[:, 2] += 0.25 * (asked.q[:, at(robot, "torso_pitch")] - robot.home[at(robot, "torso_pitch")]) / 0.2
    found, told = frame_by_frame(robot, asked, USUAL, 200.0)
    given = found.spline.at_nodes()[0]
    assert asked.q[:, 2].max() - given[:, 2].max() > 0.05
    angles = given[:, robot.base :]
    assert (angles > robot.limits.lower - 0.01).all()
    assert (angles < robot.limits.upper + 0.01).all()
    assert told.feet_m < 2e-3  # what smoothing leaves


@pytest.mark.skipif(not (CAPTURES.is_dir() and JVRC.is_file()), reason="../shared/data/model_jvrc1 is not there")
@pytest.mark.slow
@pytest.mark.parametrize("planned_too", [False, pytest.param(True, marks=pytest.mark.thorough)])
def test_a_robot_of_another_maker_does_the_bend_too(tmp_path: Path, planned_too: bool) -> None:
    """JVRC-1, 62 kg, with a torso of three joints; its soles are not in its URDF and are guessed here."""
    shutil.copy(JVRC, tmp_path / "robot.urdf")
    hinges = [joint.get("name") for joint in ElementTree.parse(JVRC).getroot().findall("joint[@type='revolute']")]
    joints = [name for name in hinges if not re.search("THUMB|INDEX|LITTLE", name)]
    outline = [[0.14, 0.05, -0.1], [-0.09, 0.05, -0.1], [-0.09, -0.05, -0.1], [0.14, -0.05, -0.1]]
    arms = {"upper_arm": "SHOULDER_Y", "forearm": "ELBOW_P", "hand": "WRIST_R"}
    bent = {"HIP_P": -0.35, "KNEE": 0.7, "ANKLE_P": -0.35, "ELBOW_P": -0.4}
    (tmp_path / "robot.yaml").write_text(yaml.safe_dump({
        "version": 1, "urdf": "robot.urdf", "base": "floating", "base_link": "PELVIS_S", "imu": {"frame": "gsensor"},
        "joints": [{"name": name, "actuation": "none"} for name in joints],
        "soles": [{"link": f"{side}_ANKLE_P_S", "outline": outline} for side in "LR"],
        "limits": {"acceleration": 40.0, "jerk": 2000.0},
        "human_map": {"pelvis": "PELVIS_S", "thorax": "WAIST_R_S"}
        | {f"{side.lower()}_{part}": f"{side}_{link}_S" for side in "LR" for part, link in arms.items()},
        "home": {"L_SHOULDER_R": 0.25, "R_SHOULDER_R": -0.25}
        | {f"{side}_{name}": value for side in "LR" for name, value in bent.items()},
    }))  # fmt: skip
    other = load_motion_robot(tmp_path / "robot.yaml")
    assert other.mass == pytest.approx(62.4, abs=0.1)
    assert [other.joints[k] for k in other.torso] == ["WAIST_Y", "WAIST_P", "WAIST_R"]
    amc = tmp_path / "02_06.amc"
    with gzip.open(CAPTURES / "02_06.amc.gz") as packed:
        amc.write_bytes(packed.read())
    asked, missed = ask(other, person_of(open_motion(amc, skeleton=CAPTURES / "02.asf")).cut(0.0, 2.6), SOON)
    assert missed.max() < 1e-3  # three joints express any turn
    if not planned_too:
        return
    planned, judged, _ = plan_within(other, asked)
    assert judged.broken == ()
    for feet in (planned, None):  # as they share the load in the plan, and evenly
        assert judge(other, planned.spline, asked.place[0], rate=1000.0, planned=feet).broken == ()


@pytest.mark.slow
@pytest.mark.skipif(not CAPTURES.is_dir(), reason="../shared/data/cmu_mocap_bend_twist is not there")
@pytest.mark.parametrize("until", [2.6, pytest.param(16.4, marks=pytest.mark.thorough)])
def test_a_captured_bend_keeps_its_bounds(robot: MotionRobot, tmp_path: Path, until: float) -> None:
    amc = tmp_path / "02_06.amc"
    with gzip.open(CAPTURES / "02_06.amc.gz") as packed:
        amc.write_bytes(packed.read())
    person = person_of(open_motion(amc, skeleton=CAPTURES / "02.asf")).cut(0.0, until)
    asked, _ = ask(robot, person, SOON)
    planned = plan(robot, asked)
    upper = np.array(robot.beyond("thorax") + robot.torso)
    torso = robot.base + np.array(robot.torso)
    wanted, given = slow(asked.q[:, torso], asked.step, USUAL.smooth_hz), planned.spline.at_nodes()[0][:, torso]
    for k, joint in enumerate(robot.torso):
        borne = np.abs(wanted[:, k]) < robot.limits.upper[joint]
        off = np.degrees(given - wanted)[borne, k]
        assert np.sqrt(np.mean(off**2)) <= 0.2
        far = np.convolve(~borne, np.ones(13), "same")[borne] == 0  # .1 s from where the joint is at its bound
        assert np.abs(off[far]).max() <= 1.0
    seen = ByMuJoCo(robot, planned.spline, 1000.0)
    assert seen.inside.min() >= 0.015
    assert np.abs(seen.feet - seen.feet[0]).max() <= 1e-4
    assert (np.abs(seen.torque[:, upper]) <= robot.limits.torque[upper]).all()
    assert judge(robot, planned.spline, asked.place[0], rate=1000.0, planned=planned).broken == ()
