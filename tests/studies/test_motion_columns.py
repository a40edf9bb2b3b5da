"""The series show the joints as they were logged and as the fit took them, each in its own unit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from exogauge.identification.preparation import prepare
from exogauge.identification.turns import rest_detection
from exogauge.logs.model import Log
from exogauge.robots.description import Joint, Robot
from exogauge.robots.urdf import load_tree
from exogauge.studies.series.write import Columns, add_motion

CUTOFF_HZ = 6.0
BODY = (
    '<link name="{0}"><inertial><origin xyz="0 0 0.1"/><mass value="2"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" '
    'iyz="0" izz="0.01"/></inertial></link>'
)
JOINT = (
    '<joint name="{0}" type="{1}"><parent link="{2}"/><child link="{3}"/><axis xyz="0 1 0"/>'
    '<limit lower="-2" upper="2" effort="50" velocity="5"/></joint>'
)


@pytest.fixture
def robot() -> Robot:
    """A turn by current, a slide by force and a turn that logs neither, in another order than the URDF's."""
    bodies = "".join(BODY.format(name) for name in ("base", "a", "b", "c"))
    joints = [("slide", "prismatic", "base", "a"), ("turn", "revolute", "a", "b"), ("free", "revolute", "b", "c")]
    urdf = f'<robot name="r">{bodies}{"".join(JOINT.format(*each) for each in joints)}</robot>'
    names = ("free", "turn", "slide")
    tree = load_tree(urdf.encode(), joints=names, base_link="base", floating=False)
    said = (Joint("free", "none"), Joint("turn", "current", prior={"k_T": 5.0}), Joint("slide", "torque"))
    return Robot("r", tree, said, None, (), np.eye(3))


@pytest.fixture
def log() -> Log:
    rng, t = np.random.default_rng(3), np.arange(0.0, 12.0, 0.005)
    names = ("q.free", "q.turn", "q.slide", "i.turn", "tau.slide")
    moved = {name: np.sin((2 + k) * t) + 1e-3 * rng.normal(size=t.size) for k, name in enumerate(names)}
    return Log("swing", t, moved)


def test_what_is_shown_is_what_the_fit_took(robot: Robot, log: Log) -> None:
    columns = Columns(log.time)
    add_motion(columns, robot, log, CUTOFF_HZ)
    table = columns.table({})
    prepared = prepare(robot, log, CUTOFF_HZ, rest_detection(robot, [log], CUTOFF_HZ))
    motion = prepared.motion
    for k, joint in enumerate(("free", "turn", "slide")):
        assert table[f"measured.q.{joint}"].to_pylist() == log.channels[f"q.{joint}"].tolist()
        for kind, values in (("q", motion.q), ("dq", motion.dq), ("ddq", motion.ddq)):
            assert np.asarray(table[f"filtered.{kind}.{joint}"]) == pytest.approx(values[:, k], rel=1e-6, abs=1e-6), (
                kind
            )
    assert table["measured.i.turn"].to_pylist() == log.channels["i.turn"].tolist()
    assert np.asarray(table["filtered.i.turn"]) == pytest.approx(prepared.drive[:, 1], rel=1e-6, abs=1e-6)


def test_a_slide_has_metres_and_only_currents_are_currents(robot: Robot, log: Log) -> None:
    columns = Columns(log.time)
    add_motion(columns, robot, log, CUTOFF_HZ)
    units = {field.name: (field.metadata or {})[b"unit"].decode() for field in columns.table({}).schema}
    assert {name: unit for name, unit in units.items() if name.endswith("slide")} == {
        "measured.q.slide": "m", "filtered.q.slide": "m", "filtered.dq.slide": "m/s", "filtered.ddq.slide": "m/s²",
    }  # fmt: skip
    assert (units["filtered.dq.turn"], units["filtered.ddq.free"], units["measured.i.turn"]) == ("rad/s", "rad/s²", "A")
    assert [name for name in units if ".i." in name] == ["measured.i.turn", "filtered.i.turn"]


def test_a_robot_whose_drives_log_torques_alone_has_no_currents(robot: Robot, log: Log) -> None:
    columns = Columns(log.time)
    torques = tuple(Joint(joint.name, "torque") for joint in robot.joints)
    add_motion(columns, replace(robot, joints=torques), log, CUTOFF_HZ)
    kinds = {name.split(".")[1] for name in columns.table({}).column_names if name != "t"}
    assert kinds == {"q", "dq", "ddq"}
