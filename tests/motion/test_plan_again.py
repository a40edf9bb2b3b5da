"""A plan that breaks a bound between its nodes or by its table is planned anew; what home lacks is told before."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from tests.motion.plans import SOON, at, bend, raises_a_knee, weak

from exogauge.criteria.motion_plan import USUAL, MotionPlan
from exogauge.motion.contract import RetargetEntry
from exogauge.motion.person import Person
from exogauge.motion.plan.asked import Asked
from exogauge.motion.plan.at_rest import PRESSURE, at_home
from exogauge.motion.plan.judge import Judged, judge
from exogauge.motion.plan.outcome import motion_table, summarise
from exogauge.motion.plan.possible import kept, what_would_do
from exogauge.motion.plan.retarget import ask
from exogauge.motion.plan.solve import Planned, Round, plan
from exogauge.motion.plan.within import plan_within
from exogauge.motion.plan.written import read_written
from exogauge.motion.retargeting import again, with_margin
from exogauge.robots.moving.robot import MotionRobot
from exogauge.robots.moving.standing import base_on


@dataclass(frozen=True)
class Careless:
    """A plan whose nodes may come nearer to the soles' edge than what is judged."""

    asked: Asked
    criteria: MotionPlan
    first: Planned
    judged: Judged


@pytest.fixture(scope="module")
def careless(robot: MotionRobot, brief) -> Careless:
    asked, criteria = brief[0], replace(USUAL, margin_m=USUAL.inside_m - 0.005)
    first = plan(robot, asked, criteria)
    return Careless(asked, criteria, first, judge(robot, first.spline, asked.place[0], planned=first))


@pytest.mark.slow
def test_what_breaks_between_the_nodes_alone_is_planned_anew(robot: MotionRobot, careless: Careless) -> None:
    """The nodes hold, and what is written does not."""
    asked = careless.asked
    assert [line.split(":")[0] for line in careless.judged.broken] == ["centre of pressure inside the soles"]
    assert careless.first.excess.max() < careless.criteria.over
    again, judged, _ = plan_within(robot, asked, careless.criteria)
    assert judged.broken == ()
    assert judged.inside.min() >= USUAL.inside_m
    assert again.spline.step == asked.step


@pytest.mark.slow
@pytest.mark.parametrize("lost", [{3}, set(range(3, 99))], ids=["the tighter one", "every other"])
def test_a_plan_stays_where_a_tighter_one_is_not_found_and_one_on_more_nodes_is_tried(
    lost: set[int], robot: MotionRobot, careless: Careless
) -> None:
    """JVRC-1's raised knee had no plan with as much more margin as it lacked, and one on 100 nodes a second. The first
    was lost with the second."""
    asked, steps = careless.asked, list[float]()

    def stop(made: Planned) -> bool:
        steps.append(made.spline.step)
        return len(steps) in lost  # the first plan's stretch is looked at twice, coarsely too; the next goes on from it

    planned, judged, given = plan_within(robot, asked, careless.criteria, stop=stop)
    finer = asked.finer(USUAL.judged_hz).step
    assert steps[:4] == pytest.approx([4.0 * asked.step, asked.step, asked.step, 4.0 * finer])
    assert planned.rounds > 0
    assert planned.spline.step == given.step
    assert judged.inside.min() >= careless.judged.inside.min() - 1e-6
    if lost == {3}:  # which of the two is the better one a hundredth of a millimetre decides, and so the machine
        assert finer < asked.step
        assert given.step in (finer, asked.step)
        assert len(judged.broken) <= 1
    else:
        assert given.step == asked.step
        assert [line.split(":")[0] for line in judged.broken] == ["centre of pressure inside the soles"]


@pytest.mark.slow
@pytest.mark.parametrize("borne", [0.9, 0.89973])
def test_what_is_exceeded_is_planned_anew_with_as_much_less(borne: float, robot: MotionRobot, brief) -> None:
    """Nodes that may take 4 % more than a joint bears, and of which every row has one. Of the second the plan made anew
    takes 1 % more than two knees may accelerate, which is nearer: it was given up for them."""
    asked, planned = brief
    pitch = robot.joints.index("torso_pitch")
    torque = robot.limits.torque.copy()
    torque[pitch] = borne * np.abs(judge(robot, planned.spline, asked.place[0], planned=planned).torque[:, pitch]).max()
    weak, criteria = replace(robot, limits=replace(robot.limits, torque=torque)), replace(USUAL, kept=1.04)
    first = plan(weak, asked, criteria)
    told = judge(weak, first.spline, asked.place[0], criteria, 1.0 / asked.step, first).broken
    assert [line.split(":")[0] for line in told] == ["torque of torso_pitch"]
    assert plan_within(weak, asked, criteria, rate=1.0 / asked.step)[1].broken == ()


def test_more_nodes_ask_the_same(robot: MotionRobot) -> None:
    asked, _ = ask(robot, raises_a_knee(), SOON)
    finer = asked.finer(200.0)
    assert finer.step == pytest.approx(0.01)
    assert finer.time[-1] == pytest.approx(asked.time[-1], abs=finer.step)
    last = len(asked.time) - 1
    for t, q, stands, place in zip(finer.time, finer.q, finer.stands, finer.place, strict=True):
        near = np.interp(t, asked.time, np.arange(last + 1))
        before, after = int(near + 1e-9), min(int(np.ceil(near - 1e-9)), last)
        assert (stands == asked.stands[before] | asked.stands[after]).all()
        between = [asked.q[before] * (1.0 - near % 1.0) + asked.q[after] * (near % 1.0)]
        assert q == pytest.approx(between[0], abs=2e-3)
        for f in range(2):
            if stands[f]:
                assert place[f].isApprox(asked.place[0][f], 1e-12)
    up = ~finer.stands[:, 0]
    highest = [
        max(each.place[t][0].translation[2] for t in np.flatnonzero(~each.stands[:, 0])) for each in (asked, finer)
    ]
    assert highest[0] == pytest.approx(highest[1], abs=1e-3)
    assert up.sum() * finer.step == pytest.approx((~asked.stands[:, 0]).sum() * asked.step, abs=2.0 * asked.step)
    assert finer.finer(100.0) is None


UNEVEN = replace(USUAL, uneven=1e3, again=0)  # feet may share the load as they like


@dataclass(frozen=True)
class Leaning:
    """A robot with a knee that bears what it is asked only where the other leg takes more; its plan."""

    robot: MotionRobot
    asked: Asked
    judged: Judged


@pytest.fixture(scope="module")
def leaning(robot: MotionRobot) -> Leaning:
    asked = bend(robot, 0.5, 0.8)
    asked.q[:, 1] += 0.1 * (asked.q[:, at(robot, "torso_pitch")] - robot.home[at(robot, "torso_pitch")])
    knee = robot.joints.index("l_knee_pitch")
    torque = robot.limits.torque.copy()
    torque[knee] = 0.9 * np.abs(judge(robot, plan(robot, asked, UNEVEN).spline, asked.place[0]).torque[:, knee]).max()
    spared = replace(robot, limits=replace(robot.limits, torque=torque))
    return Leaning(spared, asked, plan_within(spared, asked)[1])


@pytest.mark.slow
def test_legs_bear_a_plan_where_the_feet_share_evenly_too(leaning: Leaning, tmp_path: Path) -> None:
    """A table does not say how they share: the knee that a plan spared by leaning on the other was told as broken."""
    spared, asked = leaning.robot, leaning.asked
    alone = plan(spared, asked, UNEVEN)
    assert judge(spared, alone.spline, asked.place[0], planned=alone).broken == ()
    assert [line.split(":")[0] for line in judge(spared, alone.spline, asked.place[0]).broken] == [
        "torque of l_knee_pitch"
    ]
    assert leaning.judged.broken == ()
    (tmp_path / "m.csv").write_bytes(motion_table(spared, leaning.judged))
    table = read_written(spared, tmp_path / "m.csv")
    assert judge(spared, table, asked.place[0], rate=1000.0, planned=table).broken == ()


@pytest.mark.slow
def test_what_would_do_holds_where_the_plan_of_it_does(leaning: Leaning) -> None:
    """What the table of a plan breaks is broken, whoever asks."""
    spared, asked = leaning.robot, leaning.asked
    assert kept(spared, asked, USUAL)
    told = plan_within(spared, asked, UNEVEN)[1].broken
    assert told
    assert all(line.startswith("read from the table: torque of l_knee_pitch") for line in told)
    assert not kept(spared, asked, UNEVEN)


def test_what_a_robot_cannot_bear_at_home_is_told_with_what_would_do(robot: MotionRobot) -> None:
    assert at_home(robot, USUAL).excess == 0.0
    limp = at_home(weak(robot, 0.01), USUAL)
    assert limp.lacks
    enough = 1.02 * limp.needs / (limp.bears * USUAL.kept) * 0.01
    assert at_home(weak(robot, enough), USUAL).excess < 0.01
    assert at_home(weak(robot, 0.9 * enough), USUAL).excess > 0.01
    wide = with_margin(0.1)  # the soles are 11 cm wide
    narrow = at_home(robot, wide)
    assert (narrow.what, narrow.needs, narrow.lacks) == (PRESSURE, 0.1, True)
    for apart, holds in ((-1e-3, True), (1e-3, False)):
        assert (at_home(robot, with_margin(narrow.bears + apart)).excess == 0.0) is holds


@pytest.mark.slow
def test_a_plan_begins_and_ends_at_home_even_where_less_torque_would_do_beside_it(robot: MotionRobot, bent) -> None:
    """Straighter knees bear this robot; home they do not, and the plan says so in place of standing aside."""
    asked, planned = bent
    ends = planned.spline.at(np.array([0.0, planned.spline.duration]))
    assert ends[0] == pytest.approx(asked.q[[0, -1]], abs=1e-9)
    assert max(np.abs(each).max() for each in ends[1:]) < 1e-5  # rad/s²: of a control point that is off by 2e-9
    hardly = weak(robot, 1.01 * just_enough(robot))
    assert not at_home(hardly, USUAL).lacks
    assert at_home(hardly, USUAL).excess > 0.0  # what is kept of the bound for planning is too little
    found, *_ = plan_within(hardly, bend(robot, 0.2, 1.0))
    assert found.spline.at(np.zeros(1))[0][0] == pytest.approx(robot.home, abs=1e-8)  # rad: where the solver ends


def just_enough(robot: MotionRobot) -> float:
    """Share of its torque by which a robot stands at home, if nothing is kept of any bound."""
    need = at_home(weak(robot, 0.01), USUAL)
    return 0.01 * need.needs / need.bears


@pytest.mark.parametrize("share", [0.97, 0.9])
def test_what_home_lacks_is_told_at_once_with_a_home_that_would_do(robot: MotionRobot, share: float) -> None:
    """And nothing else is told of a motion that nobody planned: what is asked jumps, and would leave the ground."""
    rounds, lacking = list[Round](), weak(robot, share * just_enough(robot))
    asked = bend(robot, 0.2, 1.0)
    asked.q[20:40:2, 2] += 0.02
    planned, judged, _ = plan_within(lacking, asked, report=rounds.append)
    assert not rounds
    assert np.ptp(judged.q, axis=0) == pytest.approx(0.0, abs=1e-12)
    assert judged.carried == pytest.approx(1.0)
    assert np.ptp(judged.inside) == pytest.approx(0.0, abs=1e-9)
    assert 0.0 < judged.inside[0] < 0.11  # in a sole
    assert all("torque of " in line for line in judged.broken[2:])
    turn = np.tile(np.eye(3), (2, 1, 1))
    still = Person("still", np.arange(2.0), np.zeros((2, 3)), turn, turn, {}, 0.8)
    told = summarise(lacking, still, asked, np.zeros(1), planned, judged)
    assert not any("given" in str(line) for line in told.values())
    rest = at_home(lacking, USUAL)
    assert judged.broken[0] == str(rest)
    assert f"torque of {rest.what}" in judged.broken[0]
    assert "to stand still at home" in judged.broken[0]
    assert (np.abs(judged.torque[0]) / lacking.limits.torque).max() > 1.0
    assert rest.bend is not None
    for way, holds in ((1.0, True), (1.04, False)):
        home = robot.home.copy()
        legs = np.concatenate([robot.leg(foot) for foot in (0, 1)])
        home[legs] *= way * rest.bend
        home[: robot.base] = base_on(robot, home[None])[0]
        assert at_home(replace(lacking, home=home), USUAL).lacks is not holds


def test_nothing_is_planned_for_a_robot_that_cannot_stand_at_home(robot: MotionRobot) -> None:
    rounds = list[Round]()
    _, judged, _ = plan_within(weak(robot, 0.01), bend(robot, 0.4, 1.0), report=rounds.append)
    assert not rounds
    assert judged.broken[0].startswith("torque of ")
    assert "at home" in judged.broken[0]
    still = Person("still", np.arange(2.0), np.zeros((2, 3)), np.tile(np.eye(3), (2, 1, 1)),
                   np.tile(np.eye(3), (2, 1, 1)), {}, 0.8)  # fmt: skip
    assert what_would_do(weak(robot, 0.01), USUAL, again(weak(robot, 0.01), still, RetargetEntry())) is None
