"""A recording cut into parts is filtered as one; nothing that is held out reaches a row of the fit."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from exogauge.effects.catalogue import choose
from exogauge.identification.equations import Equations
from exogauge.identification.preparation import prepare
from exogauge.identification.prior import per_parameter, scales
from exogauge.identification.settings import Settings
from exogauge.identification.solution import solve
from exogauge.identification.turns import RestDetection
from exogauge.logs.model import Log
from exogauge.logs.segments import widened, with_beside
from exogauge.robots.description import Joint, Robot
from exogauge.robots.parameters import find_base_parameters
from exogauge.robots.row_blocks import RowBlocks
from exogauge.robots.urdf import load_tree

RATE, SECONDS, CUTOFF = 100.0, 60.0, 8.0
CUTS = (0, 1700, 3900, 6000)
URDF = b"""<robot name="pendulum"><link name="base"/>
<link name="upper"><inertial><origin xyz="0.05 0 0.2"/><mass value="3"/>
<inertia ixx="0.05" ixy="0" ixz="0" iyy="0.05" iyz="0" izz="0.02"/></inertial></link>
<link name="lower"><inertial><origin xyz="0.02 0.01 0.15"/><mass value="2"/>
<inertia ixx="0.03" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.01"/></inertial></link>
<joint name="j1" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" velocity="10" effort="100"/></joint>
<joint name="j2" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="0 0 0.4"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" velocity="10" effort="100"/></joint></robot>"""
REST = RestDetection(20.0, np.full(2, 2e-3), np.zeros(2))
SIGNALS = ("drive", "axis_velocity", "axis_acceleration", "direction", "rest", "steady", "raw_direction")


@pytest.fixture(scope="module")
def robot():
    tree = load_tree(URDF, joints=["j1", "j2"], base_link="base", floating=False)
    return Robot("pendulum", tree, (Joint("j1", "torque"), Joint("j2", "torque")), None, (), np.eye(2))


@pytest.fixture(scope="module")
def whole():
    rng = np.random.default_rng(3)
    t = 5.0 + np.arange(round(SECONDS * RATE)) / RATE
    channels = {}
    for name, waves in (("j1", (0.07, 0.16, 0.29)), ("j2", (0.05, 0.13, 0.33))):
        q = sum(0.3 * np.sin(2.0 * np.pi * hz * t + rng.uniform(0.0, 6.0)) for hz in waves)
        channels[f"q.{name}"] = q + 1e-5 * rng.normal(size=t.size)
        channels[f"tau.{name}"] = 5.0 * np.sin(q) + np.sign(np.gradient(q)) + 0.1 * rng.normal(size=t.size)
    return Log("whole", t, channels)


def part(log, start, stop):
    return Log(f"part_{start}", log.time[start:stop], {name: x[start:stop] for name, x in log.channels.items()})


@pytest.fixture(scope="module")
def parts(whole):
    alone = [part(whole, a, b) for a, b in pairwise(CUTS)]
    return [with_beside(each, alone) for each in alone]


def test_a_part_is_filtered_as_the_whole_recording_is(robot, whole, parts):
    together = prepare(robot, whole, CUTOFF, REST)
    for log, (start, stop) in zip(parts, pairwise(CUTS), strict=True):
        own = prepare(robot, log, CUTOFF, REST)
        alone = prepare(robot, replace(log, beside=None), CUTOFF, REST)
        for name in SIGNALS:
            expected = getattr(together, name)[start:stop]
            np.testing.assert_allclose(getattr(own, name), expected, atol=1e-9 * np.abs(expected).max())
        np.testing.assert_allclose(own.motion.ddq, together.motion.ddq[start:stop], atol=1e-9)
        assert np.abs(alone.drive - together.drive[start:stop]).max() > 1e-2


def test_three_parts_say_what_the_same_rows_of_one_recording_say(robot, whole, parts):
    base = find_base_parameters(robot.tree)
    equations = Equations(robot, RowBlocks(robot.tree, base, np.eye(2)), base, choose(Settings().effects))
    own = [prepare(robot, log, CUTOFF, REST) for log in parts]
    together = prepare(robot, whole, CUTOFF, REST)
    masked = [replace(together, kept=each.kept + start) for each, start in zip(own, CUTS[:-1], strict=True)]
    found = []
    for logs in (own, masked):
        prior = per_parameter(robot, base, equations.effects, scales(robot, logs))
        found.append(solve(equations, logs, prior, Settings(prior_strength=1.0)).solved.x)
    np.testing.assert_allclose(found[0], found[1], rtol=1e-9, atol=1e-9)


def test_parts_with_rows_missing_between_them_know_nothing_of_each_other(whole):
    early, late = part(whole, 0, 2000), part(whole, 2010, 6000)
    assert with_beside(early, [early, late]).beside is None
    later = part(whole, 2000, 3000)
    wide, own = widened(with_beside(early, [late, later, early]))
    assert (own.start, own.stop, wide.samples) == (0, 2000, 3000)
    np.testing.assert_allclose(wide.time, whole.time[:3000], atol=1e-9)
    np.testing.assert_array_equal(wide.channels["q.j1"], whole.channels["q.j1"][:3000])
