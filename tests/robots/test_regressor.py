"""The batched equations of motion are pinocchio's."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from exogauge.robots.kinematics import forward
from exogauge.robots.motion import Motion
from exogauge.robots.regressor import contact_effect, inverse_dynamics, regressor
from exogauge.robots.urdf import load_tree

ROBOTS = ("talos", "ur10", "panda", "odd")


def _pin_state(model, tree, order, motion, t):
    """(q, v, a) of the gravity-free model whose base carries the IMU (the fixed base falls upwards instead)."""
    q, v, a = pin.neutral(model), np.zeros(model.nv), np.zeros(model.nv)
    shift = model.nq - model.nv
    q[np.array(order) + shift], v[order], a[order] = motion.q[t], motion.dq[t], motion.ddq[t]
    if tree.floating:
        v[3:6] = motion.gyro[t]
        a[:6] = np.r_[motion.acc[t], motion.gyro_dot[t]]
    return q, v, a


@pytest.mark.parametrize("name", ROBOTS)
def test_regressor_and_inverse_dynamics_equal_pinocchios(name, robot, random_motion):
    tree, model, order = robot(name)
    motion = random_motion(tree, 5)
    if not tree.floating:
        model.gravity = pin.Motion(-motion.acc[0], np.zeros(3))
    data = model.createData()
    rows = np.r_[np.arange(6), order] if tree.floating else np.array(order)
    Y, tau = regressor(tree, motion), inverse_dynamics(tree, motion, tree.phi)
    body_of = [model.getJointId(tree.joints[j]) - 1 if j >= 0 else 0 for j in tree.dof]
    columns = np.concatenate([10 * i + np.arange(10) for i in body_of])
    for t in range(motion.samples):
        q, v, a = _pin_state(model, tree, order, motion, t)
        assert np.abs(Y[t] - pin.computeJointTorqueRegressor(model, data, q, v, a)[rows][:, columns]).max() < 1e-10
        assert np.abs(tau[t] - pin.rnea(model, data, q, v, a)[rows]).max() < 1e-10
    assert np.abs(Y @ tree.phi.ravel() - tau).max() < 1e-10


@pytest.mark.parametrize("name", ["talos", "odd"])
def test_the_imu_form_equals_the_full_state_at_any_base_pose_and_velocity(name, robot):
    tree, model, order = robot(name)
    model.gravity = pin.Motion(np.array([0.0, 0.0, -9.81]), np.zeros(3))
    data, rng = model.createData(), np.random.default_rng(5)
    for _ in range(5):
        v, a = rng.normal(size=model.nv), rng.normal(size=model.nv)
        q = np.r_[rng.normal(size=3), pin.Quaternion(pin.SE3.Random().rotation).coeffs(), rng.normal(size=model.nv - 6)]
        expected = pin.rnea(model, data, q, v, a)
        R = pin.XYZQUATToSE3(q[:7]).rotation
        acc = a[:3] + np.cross(v[3:6], v[:3]) + R.T @ np.array([0.0, 0.0, 9.81])
        q_rows = np.array(order) + 1
        motion = Motion(*(x[None] for x in (q[q_rows], v[order], a[order], acc, v[3:6], a[3:6])))
        tau = inverse_dynamics(tree, motion, tree.phi)[0]
        assert np.abs(tau - expected[np.r_[np.arange(6), order]]).max() < 1e-10


@pytest.mark.parametrize(("name", "base"), [("talos", "head_2_link"), ("talos", "imu_link"), ("odd", "tip"),
                                            ("odd", "finger"), ("odd", "leg")])  # fmt: skip
def test_a_tree_rooted_elsewhere_has_the_same_torques(name, base, robot, urdf_of, random_motion):
    tree, _, _ = robot(name)
    motion = random_motion(tree, 4)
    tau = inverse_dynamics(tree, motion, tree.phi)
    again = load_tree(urdf_of(name), joints=tree.joints, base_link=base, floating=True)
    at, pose = tree.frames[base]
    states, r = forward(tree, motion), pose.translation
    w, dw, b = states.omega[:, at], states.alpha[:, at], states.proper_acceleration[:, at]
    acc = b + np.cross(dw, r) + np.cross(w, np.cross(w, r))
    there = Motion(motion.q, motion.dq, motion.ddq, *(x @ pose.rotation for x in (acc, w, dw)))
    # the wrench that held the first base is now a contact at that link: nothing is left for the new base
    held = contact_effect(again, motion.q, tree.bodies[0], tau[:, :6])
    left = inverse_dynamics(again, there, again.phi) - held
    assert np.abs(left[:, :6]).max() < 1e-10
    assert np.abs(left[:, 6:] - tau[:, 6:]).max() < 1e-10
    assert np.abs(regressor(again, there) @ again.phi.ravel() - held - left).max() < 1e-10


@pytest.mark.parametrize(("name", "frame"), [("talos", "left_sole_link"), ("odd", "tip"), ("ur10", "tool0")])
def test_a_contact_acts_through_the_transposed_jacobian(name, frame, robot):
    tree, model, order = robot(name)
    data, rng = model.createData(), np.random.default_rng(2)
    q, wrench = rng.normal(size=(3, len(order))), rng.normal(size=(3, 6))
    effect = contact_effect(tree, q, frame, wrench)
    rows = np.r_[np.arange(6), order] if tree.floating else np.array(order)
    for t in range(3):
        full = pin.neutral(model)
        full[np.array(order) + model.nq - model.nv] = q[t]
        K = pin.computeFrameJacobian(model, data, full, model.getFrameId(frame), pin.LOCAL)
        assert np.abs(effect[t] - (K.T @ wrench[t])[rows]).max() < 1e-12


def test_a_contact_at_a_fixed_base_moves_no_joint(robot):
    tree, _, _ = robot("ur10")
    assert not contact_effect(tree, np.ones((2, 6)), "base_link", np.ones((2, 6))).any()


def test_at_rest_the_base_feels_the_weight(robot):
    tree, _, _ = robot("talos")
    rest, up = np.zeros((1, 32)), np.array([[0.0, 0.0, 9.81]])
    F = inverse_dynamics(tree, Motion(rest, rest, rest, up, 0 * up, 0 * up), tree.phi)[0]
    assert F[:3] == pytest.approx([0.0, 0.0, 9.81 * tree.mass])
