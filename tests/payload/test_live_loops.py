"""The loops of the live filter against what computes the same for whole logs."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.payload.conftest import GRAVITY, STD, arm

from exogauge.payload.contact import Compensation
from exogauge.payload.dynamics import dynamic_rows, regressor_slopes
from exogauge.payload.sensor_motion import Chain, SensorMotion
from exogauge.robots.kinematics import forward
from exogauge.robots.motion import Motion
from exogauge.robots.regressor import wrench_columns
from exogauge.robots.tree import RigidTree
from exogauge.robots.urdf import load_tree

Array = NDArray[np.float64]
SLIDING = """<robot name="gantry"><link name="base"/><link name="cart"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="arm"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><origin xyz="0.1 0.2 0.3" rpy="0.4 0.5 0.6"/>
<axis xyz="0 0 1"/><limit lower="-6" upper="6" velocity="9" effort="9"/></joint>
<joint name="slide" type="prismatic"><parent link="arm"/><child link="cart"/><origin xyz="0.5 0 0.1" rpy="0.3 0 0.2"/>
<axis xyz="0.6 0 0.8"/><limit lower="-9" upper="9" velocity="9" effort="9"/></joint>
<link name="ft"/><joint name="fixed" type="fixed"><parent link="cart"/><child link="ft"/>
<origin xyz="0.1 -0.2 0.3" rpy="0.1 0.2 0.3"/></joint></robot>"""


def gantry() -> RigidTree:
    return load_tree(SLIDING.encode(), joints=["slide", "turn"], base_link="base", floating=False)


def by_bodies(tree: RigidTree, state: Array) -> Array:
    """(T, 9) a - g, α, ω of the frame `ft`, by the kinematics of all bodies."""
    acc = np.tile(-GRAVITY, (len(state), 1))
    still = np.zeros((len(state), 3))
    moved = forward(tree, Motion(state[:, :, 0], state[:, :, 1], state[:, :, 2], acc, still, still))
    body, pose = tree.frames["ft"]
    w, dw, r = moved.omega[:, body], moved.alpha[:, body], pose.translation
    b = moved.proper_acceleration[:, body] + np.cross(dw, r) + np.cross(w, np.cross(w, r))
    return np.concatenate([b @ pose.rotation, dw @ pose.rotation, w @ pose.rotation], axis=1)


@pytest.mark.parametrize("tree", [arm(), gantry()], ids=["arm", "gantry"])
def test_the_sensor_moves_as_the_bodies_do_and_slopes_are_those_of_differences(tree: RigidTree) -> None:
    state = np.random.default_rng(0).normal(size=(50, len(tree.joints), 3))
    chain, one = Chain.of(tree, "ft"), np.broadcast_to(np.eye(3), (len(tree.joints), 3, 3))
    found = chain.motion(np.arange(50.0), state, one, GRAVITY)
    told = np.concatenate([found.proper_acceleration(GRAVITY), found.alpha, found.omega], axis=1)
    assert told == pytest.approx(by_bodies(tree, state), abs=1e-12)
    for joint in range(state.shape[1]):
        for order in range(3):
            step = np.zeros_like(state)
            step[:, joint, order] = 1e-6
            slope = (by_bodies(tree, state + step) - by_bodies(tree, state - step)) / 2e-6
            assert found.noise[:, :, 3 * joint + order] == pytest.approx(slope, abs=1e-6)


def any_motion() -> tuple[SensorMotion, Array]:
    rng = np.random.default_rng(1)
    T = 20
    turn = np.linalg.qr(rng.normal(size=(T, 3, 3)))[0]
    parts = (rng.normal(size=(T, 3)) for _ in range(3))
    return SensorMotion(np.arange(T) / 250, turn, *parts, rng.normal(size=(T, 9, 18))), rng.normal(size=(T, 6))


def test_rows_are_the_regressor_and_their_covariance_is_that_of_its_slopes() -> None:
    motion, wrench = any_motion()
    rows = dynamic_rows(motion, wrench, GRAVITY, -1, STD)
    A = wrench_columns(motion.proper_acceleration(GRAVITY), motion.alpha, motion.omega)
    assert rows.z[:, :, :10] * STD[:, None] == pytest.approx(-A, abs=1e-12)
    assert rows.z[:, :, 10:16] * STD[:, None] == pytest.approx(np.tile(np.eye(6), (20, 1, 1)), abs=1e-12)
    assert rows.z[:, :, 16] * STD == pytest.approx(wrench, abs=1e-12)
    slopes = regressor_slopes(motion.omega) / STD[:, None]
    errors = np.einsum("ktip,tkm->tpim", slopes, motion.noise).reshape(20, 10, -1)
    covariance = errors @ np.swapaxes(errors, 1, 2)
    assert rows.noise[:, :10, :10] == pytest.approx(covariance, rel=1e-9, abs=1e-9 * covariance.max())


def test_the_spread_of_what_is_left_is_that_of_sensor_kinematics_and_parameters() -> None:
    motion, wrench = any_motion()
    rng = np.random.default_rng(2)
    x, root = rng.normal(size=16), rng.normal(size=(16, 16))
    compensation = Compensation(x, root @ root.T, GRAVITY, -1, STD)
    told = compensation.spread(motion)
    A = -motion.regressor(GRAVITY)
    assert compensation.external(motion, wrench) == pytest.approx(wrench - x[10:] - A @ x[:10], abs=1e-10)
    full = np.concatenate([A, np.broadcast_to(np.eye(6), (20, 6, 6))], axis=2)
    by_motion = np.einsum("ktip,p->tik", regressor_slopes(motion.omega), x[:10]) @ motion.noise
    right = full @ root @ root.T @ np.swapaxes(full, 1, 2) + by_motion @ np.swapaxes(by_motion, 1, 2) + np.diag(STD**2)
    assert told == pytest.approx(right, rel=1e-9, abs=1e-9 * np.abs(right).max())
