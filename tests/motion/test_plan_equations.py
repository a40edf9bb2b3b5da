"""Unknowns, equations and bounds of a plan: against differences, and what a table makes of them."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.motion.plans import at, bend, table

from exogauge.cli import main
from exogauge.criteria.motion_plan import USUAL
from exogauge.motion.contract import RetargetEntry
from exogauge.motion.plan.judge import judge
from exogauge.motion.plan.rows import Watched, bounds, equations, shares, slopes, sole_rows, watch
from exogauge.motion.plan.spline import Spline, controls_of, through
from exogauge.motion.plan.written import Written, swing
from exogauge.motion.retargeting import criteria_of
from exogauge.robots.moving.robot import MotionRobot, Sole
from exogauge.robots.moving.standing import standing
from exogauge.robots.moving.touching import Pairs


def test_a_bound_that_a_round_was_near_is_in_the_equations_of_the_next(robot) -> None:
    """G1's wrists broke their jerk in one round, were far from it in the next, whose equations left it out, and so on
    without end."""
    robot = replace(robot, limits=replace(robot.limits, jerk=np.full(len(robot.joints), 2000.0)))
    asked, pairs = bend(robot, 0.6, 0.5), Pairs(replace(robot, shapes=()), USUAL.clearance_m)
    fast, calm = through(asked.q, asked.step), through(np.tile(robot.home, (len(asked.q), 1)), asked.step)
    none = np.zeros((len(asked.q), 2, 6))

    def rows(spline: Spline, watched: Watched):
        slope = slopes(robot, asked, spline, none)
        used = shares(robot, spline, slope, pairs, USUAL)
        watch(used, watched, USUAL)
        return used, *bounds(robot, asked, spline, none, slope, used, pairs, USUAL, watched)

    watched = Watched()
    broken = float(np.abs(rows(fast, watched)[0].jerk).max())
    assert broken > 2.0
    x = np.zeros((len(fast.control), robot.model.nq + 13))
    x[:, : robot.model.nq] = fast.control
    for own, seen in ((watched, True), (Watched(), False)):
        used, G, h = rows(calm, own)
        assert np.abs(used.jerk).max() < 1e-6
        assert (float((G @ x.ravel() - h).max()) >= broken - 1.0 - 1e-9) == seen


def test_a_torque_that_a_round_was_near_stays_in_the_equations_with_those_of_the_nodes_beside(robot) -> None:
    """Talos' shoulders: at one node after the other they took ten times their torque, 24 rounds long."""
    asked, pairs = bend(robot, 0.1, 0.3), Pairs(replace(robot, shapes=()), USUAL.clearance_m)
    spline, none = through(np.tile(robot.home, (len(asked.q), 1)), asked.step), np.zeros((len(asked.q), 2, 6))
    used = shares(robot, spline, slopes(robot, asked, spline, none), pairs, USUAL)
    far = replace(used, torque=np.zeros_like(used.torque))
    near = replace(far, torque=far.torque.copy())
    near.torque[6, 3] = -0.7
    watched = Watched()
    for each in (near, far):
        watch(each, watched, USUAL)
    assert not watched["torque", 1.0].any()
    found = np.argwhere(watched["torque", -1.0])
    assert set(found[:, 1]) == {3}
    assert found[:, 0].tolist() == list(range(6 - USUAL.beside, 7 + USUAL.beside))


def test_a_spline_at_its_nodes_is_the_spline_and_its_rates_are_its_slopes() -> None:
    rng = np.random.default_rng(0)
    spline = Spline(rng.normal(size=(12, 3)), 0.02)
    time = spline.step * np.arange(10)
    for whole, nodes in zip(spline.at(time[1:-1]), spline.at_nodes(), strict=True):
        assert whole == pytest.approx(nodes[1:-1])
    inner = np.linspace(0.01, spline.duration - 0.01, 50)
    _, v, a = spline.at(inner)
    ahead, behind = spline.at(inner + 1e-6), spline.at(inner - 1e-6)
    assert (ahead[0] - behind[0]) / 2e-6 == pytest.approx(v, abs=1e-5)
    assert (ahead[1] - behind[1]) / 2e-6 == pytest.approx(a, abs=2e-2)
    resting = through(rng.normal(size=(10, 3)), 0.02)
    for first_last in (resting.at_nodes()[k][[0, -1]] for k in (1, 2)):
        assert np.abs(first_last).max() < 1e-12


def test_a_spline_of_more_nodes_is_the_same_motion() -> None:
    rng = np.random.default_rng(4)
    spline = Spline(rng.normal(size=(9, 2)), 0.08)
    finer = spline.refined(4)
    assert finer.step == pytest.approx(0.02)
    assert finer.duration == pytest.approx(spline.duration)
    time = np.linspace(0.0, spline.duration, 40)
    for whole, fine in zip(spline.at(time), finer.at(time), strict=True):
        assert fine == pytest.approx(whole, abs=1e-9)
    state = [each[3] for each in spline.at_nodes()]
    assert controls_of(*state, spline.step) == pytest.approx(spline.control[3:6])


def test_the_equations_are_the_slopes_of_the_dynamics_and_of_the_feet(robot: MotionRobot) -> None:
    asked = bend(robot, 0.4, 0.2)
    rng = np.random.default_rng(1)
    N, n = asked.q.shape
    spline = Spline(through(asked.q, asked.step).control + 1e-3 * rng.normal(size=(N + 2, n)), asked.step)
    wrench = rng.normal(0.0, 50.0, (N, 2, 6))
    slope = slopes(robot, asked, spline, wrench)
    A, _ = equations(robot, asked, spline, wrench, slope)
    step, pushed = 1e-7 * rng.normal(size=(N + 2, n)), 1e-3 * rng.normal(size=(N, 2, 6))
    x = np.zeros((N + 2, n + 13))
    x[:, :n], x[1:-1, n : n + 12] = step, pushed.reshape(N, 12) / robot.weight
    moved = slopes(robot, asked, Spline(spline.control + step, asked.step), wrench + pushed)
    said = A @ x.ravel()
    driven = (moved.torque - slope.torque)[:, :6].ravel() / robot.weight
    assert said[: 6 * N] == pytest.approx(driven, abs=2e-3 * np.abs(driven).max())
    feet = np.concatenate([(moved.error - slope.error)[:, f].ravel() for f in range(2)])
    assert said[6 * N : 18 * N] == pytest.approx(feet, abs=2e-2 * np.abs(feet).max())


def test_a_sole_bears_what_presses_inside_it_and_no_more() -> None:
    sole = Sole("foot", np.array([[0.1, 0.05, -0.08], [-0.1, 0.05, -0.08], [-0.1, -0.05, -0.08], [0.1, -0.05, -0.08]]))
    assert sole.axes[:, 2] == pytest.approx([0.0, 0.0, 1.0])

    def load(x: float, y: float, along: float = 0.0) -> np.ndarray:
        """100 N that press at (x, y) of the sole, with a force along it."""
        force = np.array([along, 0.0, 100.0])
        return np.concatenate([force, np.cross([x, y, -0.08], force)])

    rows = sole_rows(sole, 0.5, 0.02)
    for inside in (load(0, 0), load(0.079, 0), load(0, -0.029), load(0.05, 0.02, 30.0)):
        assert (rows @ inside <= 1e-9).all()
    for outside in (load(0.081, 0), load(0, -0.031), load(0, 0, 40.0), -load(0, 0)):
        assert (rows @ outside > 0.0).any()


@pytest.mark.parametrize("rate", [200.0, 130.0])
def test_a_table_of_a_motion_within_its_jerk_is_within_it(robot: MotionRobot, rate: float) -> None:
    """The jerk of a plan jumps at its nodes; a cubic through samples swings beyond it there."""
    rng = np.random.default_rng(3)
    step, n = 1.0 / USUAL.nodes_per_s, robot.model.nq
    jerk = rng.choice([-1000.0, 1000.0], size=(60, n))
    control = np.cumsum(
        np.cumsum(np.cumsum(np.concatenate([np.zeros((3, n)), jerk * step**3]), axis=0), axis=0), axis=0
    )
    spline = Spline(control, step)
    time = np.arange(0.0, spline.duration, 1.0 / rate)
    table = Written(time, spline.at(time)[0], (), np.ones((len(time), 2), dtype=bool))
    found = table.jerk(np.arange(0.0, time[-1], 1e-3))
    assert 900.0 < np.abs(found).max() < 1000.0 * (1.0 + 1e-6)
    swings = np.diff(table.at(time)[2], axis=0) / np.diff(time)[:, None]
    assert np.abs(swings).max() > 1050.0
    wide = Written(time, time[:, None] ** 3 * np.ones(n), (), table.stands)
    assert wide.jerk(time) == pytest.approx(6.0)


@pytest.mark.slow
@pytest.mark.parametrize(("rate", "slower"), [(200.0, 1.0), (130.0, 1.0), (1000.0, 1.0), (200.0, 1.7)])
def test_a_table_with_a_node_on_a_row_is_the_plan_itself(robot: MotionRobot, rate: float, slower: float) -> None:
    """Written at 1 kHz, what was planned on 60 nodes a second and written at 200 Hz took 119 % of its jerk."""
    criteria, n = criteria_of(RetargetEntry(rate_hz=rate, slow=slower)), robot.model.nq
    assert criteria.nodes_per_s >= USUAL.nodes_per_s / slower - 1e-9
    step = 1.0 / criteria.nodes_per_s
    jerk = np.random.default_rng(3).choice([-1000.0, 1000.0], size=(60, n))
    jerk[-1] = jerk[-2]  # a cubic through rows has one jerk over its first two and its last two
    control = np.concatenate([np.zeros((3, n)), jerk * step**3])
    for _ in range(3):
        control = np.cumsum(control, axis=0)
    spline = Spline(control, step)
    time = np.arange(round(spline.duration * rate) + 1) / rate
    table = Written(time, spline.at(time)[0], (), np.ones((len(time), 2), dtype=bool))
    fine = np.arange(int(1000.0 * time[-1])) / 1000.0
    for ours, theirs in zip(spline.at(fine), table.at(fine), strict=True):
        assert theirs == pytest.approx(ours, abs=1e-5)
    bound = replace(robot, limits=replace(robot.limits, jerk=np.full(len(robot.joints), 1000.0 * 1.0001)))
    assert swing(bound, table, fine, table.at(fine)[0]) is None


@pytest.mark.parametrize("rate", [200.0, 130.0])
def test_a_table_of_a_motion_within_its_acceleration_is_within_it(robot: MotionRobot, rate: float) -> None:
    """G1's wrist in a squat: planned at 98 % of its acceleration, its jerk jumping; `check` of the written table told
    100.1 %, by a cubic that swings there."""
    step, n = 1.0 / USUAL.nodes_per_s, robot.model.nq
    most = 40.0 * USUAL.kept
    jumps = np.clip(np.cumsum([most, *np.tile([0.0, 0.0, -80.0, 0.0, 0.0, 80.0], 12)]), -most, most)
    control = np.cumsum(np.cumsum(np.concatenate([np.zeros(2), jumps * step**2])))
    spline = Spline(np.tile(control[:, None], n), step)
    time = np.arange(0.0, spline.duration, 1.0 / rate)
    table = Written(time, spline.at(time)[0], (), np.ones((len(time), 2), dtype=bool))
    fine = np.arange(0.0, time[-1], 1e-3)
    assert np.abs(spline.at(fine)[2]).max() == pytest.approx(most)
    assert 0.95 * most < np.abs(table.acceleration(fine)).max() < most * (1.0 + 1e-6)
    assert np.abs(table.at(fine)[2]).max() > 40.0
    limits = replace(robot.limits, acceleration=np.full(len(robot.joints), 40.0))
    for bound, told in ((40.0, 0), (0.9 * most, len(robot.joints))):
        own = replace(robot, limits=replace(limits, acceleration=np.full(len(robot.joints), bound)))
        broken = judge(own, table, standing(own), planned=table).broken
        assert sum(line.startswith("acceleration") for line in broken) == told
    wide = Written(time, time[:, None] ** 2 * np.ones(n), (), table.stands)
    assert wide.acceleration(time) == pytest.approx(2.0)


@pytest.mark.slow
def test_a_table_that_is_written_at_a_finer_rate_tells_by_how_much_its_cubic_swings(
    robot: MotionRobot, folder: Path, tmp_path: Path, capsys
) -> None:
    """`export` found every bound kept, and `check` of what it wrote a jerk of 110 %."""
    step, joints = 1.0 / USUAL.nodes_per_s, len(robot.joints)
    jerk = np.tile(np.repeat([1.0, -1.0, -1.0, 1.0, -1.0, 1.0, 1.0, -1.0], 4), 4)  # there and back, at rest at both
    control = np.cumsum(np.cumsum(np.cumsum(np.concatenate([np.zeros(3), jerk * step**3]))))
    q = np.tile(robot.home, (len(control), 1))
    q[:, at(robot, "neck_yaw")] += 0.97 * robot.jerk[robot.joints.index("neck_yaw")] * control
    spline = Spline(q, step)
    for rate, own in ((200, True), (1000, False)):
        time = np.arange(0.0, spline.duration - 1e-9, 1.0 / rate)
        angles = spline.at(time)[0][:, robot.base :]
        file = table(tmp_path / f"{rate}.csv", dict(zip(["t", *(f"q.{name}" for name in robot.joints)],
                                                        [time, *angles.T], strict=True)))  # fmt: skip
        command = ["motion", "export", str(file), "--robot", str(folder / "robot.yaml"), "--json", "--despite"]
        main([*command, "--rate", "1000", "--out", str(tmp_path / "finer.csv")])
        said = json.loads(capsys.readouterr().out)
        assert not any(line.startswith("jerk") for line in said["broken"])
        assert ("between the rows" in said) == own
        if own:
            told = json.loads((tmp_path / "finer.csv.json").read_text())
            assert told["between_the_rows"] == said["between the rows"]
            share = float(re.search(r"jerk of neck_yaw up to ([\d.]+) %", said["between the rows"])[1])
            finer = np.loadtxt(tmp_path / "finer.csv", delimiter=",", skiprows=1, usecols=range(joints + 1))
            seen = np.abs(np.diff(finer[:, 1 + robot.joints.index("neck_yaw")], 3)).max() * 1e9
            bound = robot.jerk[robot.joints.index("neck_yaw")]
            assert share == pytest.approx(100.0 * seen / bound, abs=5.0)  # eight decimals
            assert share > 102.0
