"""The robots' mechanics against pinocchio, and against what energy must do."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from scipy.integrate import cumulative_simpson

from exogauge.blind.generator.dynamics import GRAVITY, bodies_of, joint_torques, kinematics, regressor_row, tree_of
from exogauge.blind.generator.robot_files import robot_urdf
from exogauge.synthetic.inertia import of_shape


@pytest.mark.slow
def test_joint_torques_are_those_of_another_implementation(arm6, arm_model) -> None:
    rng, data = np.random.default_rng(0), arm_model.createData()
    q, dq, ddq = rng.uniform(-2.0, 2.0, (3, 50, 6))
    expected = [pin.rnea(arm_model, data, *one) for one in zip(q, dq, ddq, strict=True)]
    np.testing.assert_allclose(joint_torques(arm6.robot.tree, arm6.robot.phi, q, dq, ddq), expected, atol=1e-10)


def test_the_urdf_is_the_arm_its_maker_describes(arm6) -> None:
    model = pin.buildModelFromXML(robot_urdf("arm6", arm6.links))
    masses = {link.name: of_shape(link) for link in arm6.links if link.mass > 0.0}
    data, q = model.createData(), np.random.default_rng(1).uniform(-2.0, 2.0, (20, 6))
    expected = [pin.rnea(model, data, one, one, one) for one in q]
    tree = tree_of(arm6.links)
    np.testing.assert_allclose(joint_torques(tree, bodies_of(arm6.links, masses), q, q, q), expected, atol=1e-9)


def test_work_of_the_joints_is_energy_of_the_bodies(arm6, arm_model) -> None:
    data, motion = arm_model.createData(), arm6.motion
    load = np.stack([run.load for run in arm6.runs], axis=2)
    for log in range(2):
        power = np.sum(load[log] * motion.dq[log], axis=1)
        energy = [
            pin.computeKineticEnergy(arm_model, data, q, dq) + pin.computePotentialEnergy(arm_model, data, q)
            for q, dq in zip(motion.q[log], motion.dq[log], strict=True)
        ]
        work = cumulative_simpson(power, x=motion.time, initial=0.0)
        np.testing.assert_allclose(work, np.subtract(energy, energy[0]), atol=1e-4 * np.ptp(energy))


def test_motors_give_what_bodies_rotors_and_friction_take(arm6) -> None:
    """Without hidden effects nothing else takes part, at rest too."""
    for run in arm6.runs:
        d = run.drive
        left = d.k_T * (run.motor / d.k_T) + d.tau_o - run.load - d.J_r * run.ddq - d.k_d * run.dq - run.friction
        assert np.abs(left).max() < 1e-10
        assert np.all(np.abs(run.friction[run.direction == 0.0]) <= d.tau_s + 1e-12)
        np.testing.assert_allclose(run.friction[run.direction != 0.0], d.tau_c * run.direction[run.direction != 0.0])


def test_inertia_and_stiffness_of_a_link_are_those_of_another_implementation(arm6, arm_model) -> None:
    data, motion = arm_model.createData(), arm6.motion
    for sample in (0, 700, 4999):
        q = motion.q[0, sample]
        M = pin.crba(arm_model, data, q)
        slope = pin.computeGeneralizedGravityDerivatives(arm_model, data, q)
        for joint, run in enumerate(arm6.runs):
            np.testing.assert_allclose(run.inertia[0, sample], M[joint, joint], rtol=1e-3)
            np.testing.assert_allclose(run.stiffness[0, sample], slope[joint, joint], atol=0.05)


def test_a_joints_torque_is_linear_in_the_bodies_it_carries(arm6) -> None:
    rng = np.random.default_rng(2)
    q, dq, ddq = rng.uniform(-2.0, 2.0, (3, 30, 6))
    tree, phi = arm6.robot.tree, arm6.robot.phi
    torque, moving = joint_torques(tree, phi, q, dq, ddq), kinematics(tree, q, dq, ddq)
    for joint in range(6):
        row = regressor_row(tree, moving, joint)
        np.testing.assert_allclose(row @ phi[joint:].ravel(), torque[:, joint], atol=1e-10)


def test_gravity_acts_downwards_on_an_upright_arm(arm_model) -> None:
    assert arm_model.gravity.linear[2] == -GRAVITY


@pytest.mark.slow
def test_an_upper_body_moves_as_another_implementation_says(torso8, torso_model) -> None:
    data, rng = torso_model.createData(), np.random.default_rng(3)
    order = [torso_model.joints[torso_model.getJointId(name)].idx_v for name in torso8.joints]
    for q, dq, ddq in rng.uniform(-1.0, 1.0, (10, 3, 8)):
        inner = np.argsort(order)
        expected = pin.rnea(torso_model, data, q[inner], dq[inner], ddq[inner])[order]
        torque = joint_torques(torso8.robot.tree, torso8.robot.phi, q[None], dq[None], ddq[None])
        np.testing.assert_allclose(torque[0], expected, atol=1e-10)
