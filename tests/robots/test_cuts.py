"""A sensor inside the robot reads what the bodies beyond it ask for, and nothing of those before it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from exogauge.errors import BadRobot
from exogauge.robots.cuts import CutRows
from exogauge.robots.export import export_urdf
from exogauge.robots.motion import Motion
from exogauge.robots.parameters import find_base_parameters
from exogauge.robots.regressor import cut_regressor, cut_wrench, regressor
from exogauge.robots.row_blocks import BodyLoads, RowBlocks, Swept
from exogauge.robots.urdf import load_tree

LINK = (
    '<link name="{name}"><inertial><origin xyz="{c}"/><mass value="{m}"/>'
    '<inertia ixx="0.05" ixy="0.003" ixz="0.002" iyy="0.04" iyz="-0.001" izz="0.03"/></inertial></link>'
)
JOINT = (
    '<joint name="{name}" type="{kind}"><parent link="{a}"/><child link="{b}"/><origin xyz="{xyz}" rpy="{rpy}"/>'
    "{axis}</joint>"
)


def _joint(name: str, kind: str, a: str, b: str, xyz: str, rpy: str, axis: str = "") -> str:
    written = f'<axis xyz="{axis}"/><limit lower="-3" upper="3" effort="50" velocity="5"/>' if axis else ""
    return JOINT.format(name=name, kind=kind, a=a, b=b, xyz=xyz, rpy=rpy, axis=written)


def _arm(sensor_mass: float = 0.0) -> bytes:
    """Pedestal, foot sensor, two links, wrist sensor, tool, and a finger that moves beyond it."""
    sensor = LINK.format(name="wrist_ft", c="0 0 0.01", m=sensor_mass) if sensor_mass else '<link name="wrist_ft"/>'
    return "".join([
        '<robot name="arm"><link name="stand"/>', '<link name="foot_ft"/>',
        LINK.format(name="plate", c="0.1 0 0.02", m=4.0), LINK.format(name="upper", c="0.1 0.02 0.1", m=3.0),
        LINK.format(name="fore", c="0.02 0.05 0.12", m=2.0), sensor, LINK.format(name="tool", c="0.03 0 0.08", m=0.8),
        LINK.format(name="camera", c="0 0.02 0", m=0.2), LINK.format(name="finger", c="0.01 0 0.03", m=0.1),
        _joint("ground", "fixed", "stand", "foot_ft", "0 0 0.1", "0 0 0.3"),
        _joint("bolted", "fixed", "foot_ft", "plate", "0 0 0.05", "0.2 0 0"),
        _joint("shoulder", "revolute", "plate", "upper", "0 0 0.2", "0.1 0.2 0.3", "0 1 0"),
        _joint("elbow", "revolute", "upper", "fore", "0.05 0 0.3", "0 0.4 0", "1 0 0"),
        _joint("flange", "fixed", "fore", "wrist_ft", "0 0.01 0.25", "0.3 0 0.1"),
        _joint("mount", "fixed", "wrist_ft", "tool", "0 0 0.04", "0 0.2 0"),
        _joint("clip", "fixed", "tool", "camera", "0.05 0 0.05", "0 0 1.0"),
        _joint("grip", "revolute", "tool", "finger", "0.02 0 0.1", "0 0 0", "0 0 1"),
        "</robot>",
    ]).encode()  # fmt: skip


JOINTS = ("shoulder", "elbow", "grip")


def _tree(*sensors: str, urdf: bytes | None = None):
    return load_tree(urdf or _arm(), joints=JOINTS, base_link="stand", floating=False, carrying=sensors)


def _motion(samples: int = 9) -> Motion:
    rng = np.random.default_rng(4)
    q, dq, ddq = rng.normal(size=(3, samples, 3))
    still = np.zeros((samples, 3))
    return Motion(q, dq, ddq, np.tile([0.0, 0.0, 9.81], (samples, 1)), still, still)


def _reading_by_pinocchio(motion: Motion, frame: str, beyond: set[str]) -> np.ndarray:
    """(T, 6) force then moment in the sensor's frame: Newton and Euler link by link, all joints moving."""
    model = pin.buildModelFromXML(_arm().decode())
    data = model.createData()
    readings = []
    for q, dq, ddq in zip(motion.q, motion.dq, motion.ddq, strict=True):
        pin.forwardKinematics(model, data, q, dq, ddq)
        pin.updateFramePlacements(model, data)
        sensor = data.oMf[model.getFrameId(frame)]
        total = pin.Force.Zero()
        for name in beyond:
            inertia = {"tool": (0.8, [0.03, 0, 0.08]), "camera": (0.2, [0, 0.02, 0]), "finger": (0.1, [0.01, 0, 0.03]),
                       "fore": (2.0, [0.02, 0.05, 0.12]), "upper": (3.0, [0.1, 0.02, 0.1]),
                       "plate": (4.0, [0.1, 0, 0.02])}[name]  # fmt: skip
            I = np.array([[0.05, 0.003, 0.002], [0.003, 0.04, -0.001], [0.002, -0.001, 0.03]])  # noqa: E741
            body = pin.Inertia(inertia[0], np.array(inertia[1]), I)
            k = model.getFrameId(name)
            v = pin.getFrameVelocity(model, data, k)
            a = pin.getFrameAcceleration(model, data, k)
            a.linear = a.linear + data.oMf[k].rotation.T @ np.array([0, 0, 9.81])
            f = body * a + v.cross(body * v)
            total = total + data.oMf[k].act(f)
        readings.append(sensor.actInv(total).vector)
    return np.array(readings)


CASES = [
    ("wrist_ft", "wrist_ft", {"tool", "camera", "finger"}),
    ("foot_ft", "foot_ft", {"plate", "upper", "fore", "tool", "camera", "finger"}),
    ("mount", "tool", {"tool", "camera", "finger"}),
    ("upper", "upper", {"fore", "tool", "camera", "finger"}),
]


@pytest.mark.parametrize(("frame", "sensor", "beyond"), CASES, ids=[case[0] for case in CASES])
def test_a_reading_is_newton_and_euler_of_the_links_beyond(frame, sensor, beyond):
    tree, motion = _tree(frame), _motion()
    expected = pytest.approx(_reading_by_pinocchio(motion, sensor, beyond), abs=1e-10)
    assert cut_regressor(tree, motion, frame) @ tree.phi.ravel() == expected
    assert cut_wrench(tree, motion, frame, tree.phi) == expected


@pytest.mark.parametrize("sensors", [("wrist_ft",), ("foot_ft",), ("wrist_ft", "foot_ft")])
def test_splitting_a_link_changes_nothing_of_the_joints(sensors):
    whole, tree, motion = _tree(), _tree(*sensors), _motion()
    base = find_base_parameters(tree)
    rows = RowBlocks(tree, base, np.eye(3))
    expected = (regressor(whole, motion) @ whole.phi.ravel()).T
    told = [block @ (base.regroup @ tree.phi.ravel())[own]
            for block, own in zip(rows.fill(motion), rows.columns, strict=True)]  # fmt: skip
    assert np.array(told) == pytest.approx(expected, abs=1e-10)
    if "foot_ft" not in sensors:
        assert tree.mass == pytest.approx(whole.mass, abs=1e-12)


@pytest.mark.parametrize("sensors", [("wrist_ft",), ("foot_ft",), ("wrist_ft", "foot_ft")])
def test_rows_in_base_parameters_are_the_dense_ones(sensors):
    tree, motion = _tree(*sensors), _motion()
    base = find_base_parameters(tree)
    for frame in sensors:
        cut = CutRows(tree, base, frame)
        dense = cut_regressor(tree, motion, frame)[:, :, base.columns]
        for row, (block, own) in enumerate(zip(cut.fill(motion, [2] * 6), cut.columns, strict=True)):
            rest = np.delete(dense[:, row], own, axis=1)
            assert block[:, :-2] == pytest.approx(dense[:, row, own], abs=1e-11)
            assert not block[:, -2:].any()
            assert not rest.any()


@pytest.mark.parametrize("sensors", [(), ("wrist_ft",), ("wrist_ft", "foot_ft"), ("foot_ft", "wrist_ft")])
@pytest.mark.parametrize("coupled", [False, True])
def test_loads_are_the_rows_times_the_parameters(sensors, coupled):
    tree, motion = _tree(*sensors), _motion()
    base, C = find_base_parameters(tree), np.eye(3)
    C[0, 2] = 0.5 if coupled else 0.0
    phi = np.random.default_rng(3).normal(size=(base.rank, 2))
    phi[:4, 1] = 0.0  # a body that asks for nothing
    rows = RowBlocks(tree, base, C)
    expected = [block @ phi[own] for block, own in zip(rows.fill(motion), rows.columns, strict=True)]
    for frame in sensors:
        cut = CutRows(tree, base, frame)
        expected += [block @ phi[own] for block, own in zip(cut.fill(motion), cut.columns, strict=True)]
    found = BodyLoads(tree, base.columns, C, sensors).of(motion, phi)
    assert found == pytest.approx(np.transpose(expected, (2, 0, 1)), abs=1e-10)


def test_one_joint_that_moves_otherwise_is_a_motion_that_differs_in_that_joint():
    motion, more = _motion(), np.random.default_rng(4).normal(size=(3, 9))
    q, dq, ddq = motion.q.copy(), motion.dq.copy(), motion.ddq.copy()
    for each, own in zip((q, dq, ddq), more, strict=True):
        each[:, 1] += own
    swept = Swept.of(motion)
    found = swept.with_joint(1, more)
    expected = Swept.of(replace(motion, q=q, dq=dq, ddq=ddq))
    np.testing.assert_array_equal(found.signals, expected.signals)
    np.testing.assert_array_equal(found.q, q)
    np.testing.assert_array_equal(swept.signals, Swept.of(motion).signals)  # left as it is


def test_a_sensor_tells_the_tool_from_the_link_before_it():
    without, with_sensor = (find_base_parameters(_tree(*sensors)) for sensors in ((), ("wrist_ft",)))
    assert with_sensor.rank > without.rank
    assert any(name == "m[tool]" or name.startswith("m[tool") or "tool" in name for name in with_sensor.names)


def test_the_sensors_own_mass_is_not_in_its_reading():
    heavy, light = (_tree("wrist_ft", urdf=_arm(mass)) for mass in (0.3, 0.0))
    motion = _motion()
    told = [cut_regressor(tree, motion, "wrist_ft") @ tree.phi.ravel() for tree in (heavy, light)]
    assert told[0] == pytest.approx(told[1], abs=1e-12)
    assert heavy.mass == pytest.approx(light.mass + 0.3)


def test_an_unknown_frame_is_refused_by_name():
    with pytest.raises(BadRobot, match="ft_nowhere"):
        _tree("ft_nowhere")


def test_identified_inertias_go_back_to_the_side_of_the_sensor_they_are_on():
    urdf = _arm()
    tree = _tree("wrist_ft", urdf=urdf)
    phi = tree.phi.copy()
    phi[tree.bodies.index("tool")] *= 1.5
    again = load_tree(export_urdf(urdf, tree, phi), joints=JOINTS, base_link="stand", floating=False,
                      carrying=["wrist_ft"])  # fmt: skip
    assert again.phi == pytest.approx(phi, abs=1e-9)
