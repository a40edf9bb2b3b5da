"""The wrench at a force/torque sensor: sums of forces, weights, another implementation."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from exogauge.blind.generator.cut import cut_columns, cut_wrench, links_beyond
from exogauge.blind.generator.dynamics import GRAVITY, UP, kinematics
from exogauge.blind.generator.motion import RATE_HZ
from exogauge.blind.generator.places import poses


@pytest.mark.slow
def test_a_tool_at_rest_weighs_on_the_sensor_in_every_posture(arm6) -> None:
    robot, none = arm6.robot, np.zeros((40, 6))
    q = np.random.default_rng(1).uniform(-2.0, 2.0, (40, 6))
    wrench = cut_wrench(robot.tree, robot.phi, robot.cut, kinematics(robot.tree, q, none, none))
    mass = robot.cut.rigid[0]
    assert 0.3 < mass < 2.6
    np.testing.assert_allclose(np.linalg.norm(wrench[:, :3], axis=1), mass * GRAVITY, atol=1e-12)
    turned = poses(robot.tree, q).rotation[robot.cut.body]
    np.testing.assert_allclose(np.einsum("nij,nj->ni", turned, wrench[:, :3])[:, 2], -mass * GRAVITY, atol=1e-12)
    centre = robot.cut.rigid[1:4] / mass - robot.cut.place
    np.testing.assert_allclose(wrench[:, 3:], np.cross(centre, wrench[:, :3]), atol=1e-12)


def test_force_on_the_tool_is_mass_times_acceleration_of_its_centre(arm6) -> None:
    """The centre's path differentiated twice, along a log."""
    robot, motion, log = arm6.robot, arm6.motion, 1
    centre = (robot.cut.body, robot.cut.rigid[1:4] / robot.cut.rigid[0])
    at = poses(robot.tree, motion.q[log])
    acceleration = np.diff(at.at(centre), n=2, axis=0) * RATE_HZ**2
    force = np.einsum("nij,nj->ni", at.rotation[robot.cut.body], arm6.wrench[log, :, :3])[1:-1]
    expected = -robot.cut.rigid[0] * (acceleration + UP)
    np.testing.assert_allclose(force, expected, atol=0.02 * np.abs(acceleration).max())
    assert np.abs(acceleration).max() > 1.0


def test_a_tool_moves_as_another_implementation_says(arm6, arm_model) -> None:
    robot, cut = arm6.robot, arm6.robot.cut
    data, joint = arm_model.createData(), arm_model.getJointId("joint_6")
    body, there = pin.Inertia.FromDynamicParameters(cut.rigid), pin.SE3(np.eye(3), cut.place)
    for q, dq, ddq in np.random.default_rng(2).uniform(-2.0, 2.0, (10, 3, 6)):
        pin.forwardKinematics(arm_model, data, q, dq, ddq)
        v, a = data.v[joint], data.a[joint]
        up = data.oMi[joint].rotation.T @ np.array([0.0, 0.0, GRAVITY])
        needed = there.actInv(body * (a + pin.Motion(up, np.zeros(3))) + v.cross(body * v))
        moving = kinematics(robot.tree, q[None], dq[None], ddq[None])
        np.testing.assert_allclose(cut_wrench(robot.tree, robot.phi, cut, moving)[0], -needed.vector, atol=1e-10)


@pytest.mark.slow
def test_under_an_upper_body_is_the_change_of_all_momentum(torso8, torso_model) -> None:
    robot, cut = torso8.robot, torso8.robot.cut
    data, rng = torso_model.createData(), np.random.default_rng(3)
    inner = np.argsort([torso_model.joints[torso_model.getJointId(name)].idx_v for name in torso8.joints])
    for q, dq, ddq in rng.uniform(-1.0, 1.0, (10, 3, 8)):
        change = pin.computeCentroidalMomentumTimeVariation(torso_model, data, q[inner], dq[inner], ddq[inner])
        mass, centre = data.mass[0], data.com[0]
        needed = change.linear + mass * UP
        moment = change.angular + np.cross(centre - cut.place, needed)
        weight = cut.rigid[0] * UP
        base = np.cross(cut.rigid[1:4] / cut.rigid[0] - cut.place, weight)
        moving = kinematics(robot.tree, q[None], dq[None], ddq[None])
        wrench = cut_wrench(robot.tree, robot.phi, cut, moving)[0]
        np.testing.assert_allclose(wrench[:3], -(needed + weight), atol=1e-9)
        np.testing.assert_allclose(wrench[3:], -(moment + base), atol=1e-9)


@pytest.mark.slow
def test_the_pedestal_does_not_weigh_on_the_sensor_above_it(torso8) -> None:
    beyond = links_beyond(torso8.links, "mount")
    assert "pedestal" not in beyond
    assert {"BODY", "chest", "l_hand"} <= beyond
    assert torso8.robot.cut.bodies == tuple(range(8))


@pytest.mark.parametrize("which", ["arm6", "torso8"])
def test_the_wrench_is_linear_in_what_is_carried(which: str, request) -> None:
    scene = request.getfixturevalue(which)
    robot = scene.robot
    q, dq, ddq = np.random.default_rng(4).uniform(-1.0, 1.0, (3, 20, len(robot.phi)))
    moving = kinematics(robot.tree, q, dq, ddq)
    phi = np.concatenate([robot.phi[list(robot.cut.bodies)].ravel(), robot.cut.rigid])
    columns = cut_columns(robot.tree, robot.cut, moving)
    np.testing.assert_allclose(columns @ phi, cut_wrench(robot.tree, robot.phi, robot.cut, moving), atol=1e-10)


def test_a_sensors_baseline_absorbs_what_is_carried_and_its_zero_and_nothing_else(arm6) -> None:
    absorbing = arm6.cut_baseline
    assert absorbing.excess(1.3 * arm6.wrench + np.arange(6.0)).max() < 0.02 * np.abs(arm6.wrench).max() / 0.1
    one = np.zeros_like(arm6.wrench)
    one[:, :, 1] = 0.1 * arm6.wrench[:, :, 1]
    assert absorbing.excess(one).max() > 1.0
