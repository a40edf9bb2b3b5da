"""The columns of one body, by the dense regressor; and a weighed load as parameters of the body that carries it."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from tests.sensor_arm import Sensor, describe, wrist

from exogauge.robots.body_rows import body_rows
from exogauge.robots.description import KnownLoad
from exogauge.robots.motion import Motion
from exogauge.robots.regressor import cut_regressor, regressor
from exogauge.robots.urdf import load_tree

COUPLING = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.4, 0.0], [0.0, 0.0, 1.0, -0.3], [0.0, 0.0, 0.0, 1.0]])


def moving(rng, joints, samples=2300):
    """Longer than what is computed at once."""
    q, dq, ddq = rng.normal(size=(3, samples, joints))
    return Motion(q, dq, ddq, *rng.normal(size=(3, samples, 3)))


@pytest.mark.parametrize("floating", [False, True])
def test_rows_of_a_body_are_its_columns_of_the_dense_regressor(tmp_path, floating):
    from tests.sensor_arm import urdf

    joints = ("j1", "j2", "j3", "j4")
    tree = load_tree(urdf().encode(), joints=joints, base_link="stand", floating=floating)
    motion = moving(np.random.default_rng(1), 4)
    dense = regressor(tree, motion)
    first = 6 if floating else 0
    dense[:, first:] = np.einsum("ja,tjp->tap", np.linalg.inv(COUPLING), dense[:, first:])
    for body in range(len(tree.bodies)):
        rows = body_rows(tree, COUPLING, motion, body)
        np.testing.assert_allclose(rows, dense[:, :, 10 * body : 10 * body + 10], atol=1e-11)


def test_a_sensor_feels_the_bodies_beyond_it_and_no_other(tmp_path):
    robot = describe(tmp_path, [wrist(), Sensor("foot", "foot_ft", "world_on_robot")])
    motion, frames = moving(np.random.default_rng(2), 4, 50), [sensor.frame for sensor in robot.cuts]
    dense = np.concatenate([cut_regressor(robot.tree, motion, frame) for frame in frames], axis=1)
    for body in range(len(robot.tree.bodies)):
        rows = body_rows(robot.tree, robot.axes_from_joints, motion, body, frames)[:, 4:]
        np.testing.assert_allclose(rows, dense[:, :, 10 * body : 10 * body + 10], atol=1e-11)


def test_coefficients_of_a_load_are_those_of_a_body_at_its_centre():
    """A lump whose centre is off by δ: mass, m δ, and its inertia about the stated centre with that of a mass at δ."""
    centre, off = np.array([0.02, -0.05, 0.11]), np.array([0.013, 0.007, -0.021])
    about = np.array([[0.03, 0.004, -0.002], [0.004, 0.05, 0.001], [-0.002, 0.001, 0.04]])
    load = KnownLoad("hand", 0, 4.2, 0.01, tuple(centre), 0.02, ("a",))
    true = pin.Inertia(4.3, centre + off, about)
    rest = about + 4.3 * (off @ off * np.eye(3) - np.outer(off, off))
    coefficients = [4.3, *(4.3 * off), rest[0, 0], rest[0, 1], rest[1, 1], rest[0, 2], rest[1, 2], rest[2, 2]]
    np.testing.assert_allclose(load.columns @ coefficients, true.toDynamicParameters(), atol=1e-14)
    point = pin.Inertia(4.2, centre, np.zeros((3, 3)))
    np.testing.assert_allclose(load.phi, point.toDynamicParameters(), atol=1e-14)
