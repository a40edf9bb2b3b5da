"""A foot of the person lifts, and the robot's does: where each is, which of them bears."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.motion.by_mujoco import ByMuJoCo
from tests.motion.plans import SOON, at, columns_of, raises_a_knee, table

from exogauge.cli import main
from exogauge.criteria.motion_plan import USUAL
from exogauge.errors import BadMotion
from exogauge.motion.human import Contacts
from exogauge.motion.person import Person
from exogauge.motion.plan.judge import judge
from exogauge.motion.plan.outcome import motion_table
from exogauge.motion.plan.retarget import ask
from exogauge.motion.plan.within import plan_within, read_again
from exogauge.motion.plan.written import Written
from exogauge.robots.moving.robot import MotionRobot
from exogauge.robots.moving.standing import base_on


@pytest.fixture(scope="module")
def raised(robot: MotionRobot):
    asked, _ = ask(robot, raises_a_knee(), SOON)
    return asked, *plan_within(robot, asked)[:2]


@pytest.mark.parametrize("rate", [USUAL.nodes_per_s, 100.0])
def test_a_foot_is_where_it_stands_until_no_node_beside_bears(robot: MotionRobot, rate: float) -> None:
    """It may bear between a node at which it stands and the next: G1's was led .13 mm off there."""
    asked, _ = ask(robot, raises_a_knee(), replace(SOON, nodes_per_s=rate))
    lifted = ~asked.stands[:, 0]
    edge = np.flatnonzero(lifted & (asked.stands[:, 0].take(np.arange(1, len(lifted) + 1), mode="clip")
                                    | np.roll(asked.stands[:, 0], 1)))  # fmt: skip
    assert len(edge) == 2
    for t in (*edge, *np.flatnonzero(asked.stands[:, 0])):
        assert asked.place[t][0].isApprox(asked.place[0][0], 1e-12)
    highest = max(asked.place[t][0].translation[2] for t in np.flatnonzero(lifted))
    assert highest - asked.place[0][0].translation[2] == pytest.approx(0.2 * 0.6 / 0.8, abs=0.01)


@pytest.mark.slow
def test_a_knee_that_is_raised_is_raised_on_the_other_foot_as_mujoco_sees_it(robot: MotionRobot, raised) -> None:
    asked, planned, judged = raised
    assert judged.broken == ()
    rate = 1000.0
    time = np.arange(int(planned.spline.duration * rate + 1e-6) + 1) / rate
    stands = planned.standing(time)
    assert 0.2 < (~stands[:, 0]).mean() < 0.3  # .9 of 3.4 s
    seen = ByMuJoCo(robot, planned.spline, rate, stands)
    assert seen.inside.min() >= 0.015
    assert np.abs(seen.feet[:, 1] - seen.feet[0, 1]).max() <= 1e-4
    lifted = seen.feet[:, 0] - seen.feet[0, 0]
    assert np.abs(lifted[stands[:, 0]]).max() <= 1e-4
    size = 0.6 / 0.8  # hips over the soles, of the robot and of the person
    assert lifted.max(axis=0) == pytest.approx([0.1 * size, 0.0, 0.2 * size], abs=0.01)
    both = judge(robot, planned.spline, asked.place[0], rate=rate).broken
    assert any(line.startswith("way of a standing foot") for line in both), "were it to stand"


@pytest.mark.slow
def test_a_table_says_which_foot_is_up_and_is_judged_on_the_one_that_stands(
    robot: MotionRobot, raised, folder: Path, tmp_path: Path, capsys
) -> None:
    _, planned, judged = raised
    file = tmp_path / "raise.csv"
    file.write_bytes(motion_table(robot, judged))
    columns = columns_of(file)
    assert (columns["stands.r_foot"] == 1.0).all()
    assert (columns["stands.l_foot"] == planned.standing(judged.time)[:, 0]).all()
    command = ["--robot", str(folder / "robot.yaml"), "--json"]
    assert main(["motion", "check", str(file), *command]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["broken"] == []
    assert float(said["centre of pressure"].split()[0]) == pytest.approx(1e3 * judged.inside.min(), abs=1.0)
    read = read_again(robot, judged, SOON, 200.0)
    # told to a tenth of a millimetre, of a table whose last digits move that by a few micrometres
    assert float(said["centre of pressure"].split()[0]) == pytest.approx(1e3 * read.inside.min(), abs=0.055)
    assert read.broken == ()
    assert said["feet that lift"].startswith("l_foot from 1.2")
    for form, rate in (("csv", "500"), ("mujoco", "1000"), ("hrpsys", "200")):
        out = tmp_path / f"again.{form}"
        assert main(["motion", "export", str(file), *command, "--format", form, "--rate", rate, "--out", str(out)]) == 0
        sheet = json.loads((tmp_path / f"again.{form}.json").read_text())
        ((up, down),) = sheet["feet_up_s"]["l_foot"]
        assert (up, down) == (pytest.approx(1.2, abs=0.06), pytest.approx(2.2, abs=0.06))
    capsys.readouterr()
    assert "stands.l_foot" in columns_of(tmp_path / "again.csv")
    seen = np.load(tmp_path / "again.npz")
    on = seen["stands"][:, list(seen["feet"]).index("l_foot")]
    assert (on == planned.standing(seen["time"])[:, 0]).mean() > 0.99
    silent = {name: values for name, values in columns.items() if not name.startswith("stands.")}
    assert main(["motion", "check", str(table(tmp_path / "silent.csv", silent)), *command]) == 1
    broken = json.loads(capsys.readouterr().out)["broken"]
    assert any(line.startswith("way of a standing foot") for line in broken)
    wrong = columns | {"stands.r_foot": columns["stands.l_foot"], "stands.l_foot": columns["stands.r_foot"]}
    assert main(["motion", "check", str(table(tmp_path / "wrong.csv", wrong)), *command]) == 1
    assert any(line.startswith("centre of pressure") for line in json.loads(capsys.readouterr().out)["broken"])


def test_the_base_is_where_the_feet_that_stand_put_it(robot: MotionRobot) -> None:
    """A foot that lifts moves nothing; where either lifts once, the base goes over without a jump."""
    T = 41
    q = np.tile(robot.home, (T, 1))
    up = np.ones((T, 2), dtype=bool)
    up[10:16, 0] = False
    q[10:16, at(robot, "l_hip_pitch")] -= 0.3
    assert base_on(robot, q, up) == pytest.approx(q[:, :6], abs=1e-9)
    assert np.abs(base_on(robot, q) - q[:, :6]).max() > 0.1, "were the left one to stand"
    up[25:31, 1] = False
    q[25:31, at(robot, "r_hip_pitch")] -= 0.3
    assert base_on(robot, q, up) == pytest.approx(q[:, :6], abs=1e-9)
    q[:, at(robot, "l_ankle_roll")] += 1e-4  # a table that is a little wrong
    whole = base_on(robot, q, up)
    assert np.abs(np.diff(whole, 3, axis=0)).max() < 2e-5 < np.ptp(whole, axis=0).max()


def test_between_up_and_down_a_foot_may_bear_and_may_move() -> None:
    time = np.arange(6) / 10.0
    stands = np.ones((6, 2), dtype=bool)
    stands[2:4, 0] = False
    table = Written(time, np.zeros((6, 8)), (), stands)
    at = np.array([0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4])
    assert table.standing(at)[:, 0].tolist() == [True, True, False, False, False, True, True]
    assert table.still(at)[:, 0].tolist() == [True, False, False, False, False, False, True]
    assert table.still(at)[:, 1].all()


def test_a_foot_that_is_up_at_an_end_or_for_a_moment(robot: MotionRobot) -> None:
    whole = raises_a_knee()
    for begin, end, says in ((0.8, 2.0, "begins"), (0.0, 1.2, "ends")):
        with pytest.raises(BadMotion, match=f"left foot is up when the motion {says}"):
            ask(robot, whole.cut(begin, end))
    moment = replace(whole, contacts=Contacts(np.abs(whole.time - 1.0) > 0.1, whole.contacts.right))
    asked, _ = ask(robot, moment)
    assert asked.stands.all()
    mirrored, _ = ask(robot, whole.mirrored())
    assert mirrored.stands[:, 0].all()
    assert not mirrored.stands[:, 1].all()


def test_a_jump_is_refused_with_its_time(robot: MotionRobot) -> None:
    T = 100
    still = np.tile(np.eye(3), (T, 1, 1))
    up = np.ones(T, dtype=bool)
    up[40:60] = False
    jumps = Person("jump", 0.01 * np.arange(T), np.zeros((T, 3)), still, still, {}, 0.8, Contacts(up, up))
    with pytest.raises(BadMotion) as told:
        ask(robot, jumps)
    assert told.value.faults[0].value == "0.40 to 0.59 s"
    asked, missed = ask(robot, jumps.cut(0.0, 0.3))
    assert np.abs(missed).max() < 1e-6
    assert np.abs(asked.q[:, robot.base + np.array(robot.torso)]).max() < 1e-6
