"""The flat base must be the same robot as one on a free-flyer, in coordinates that add up."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from exogauge.robots.joint_limits import JointLimits
from exogauge.robots.moving.robot import BASE, MotionRobot, flat_model
from exogauge.synthetic.robot_facts import JOINTS
from exogauge.synthetic.urdf import robot_urdf

NAMES = tuple(joint.name for joint in JOINTS)


@pytest.fixture(scope="module")
def model() -> pin.Model:
    return flat_model(robot_urdf().encode(), NAMES, floating=True)


def test_weight_and_inertia_are_those_of_the_free_flying_robot(model) -> None:
    free = pin.buildModelFromXML(robot_urdf(), pin.JointModelFreeFlyer())
    rng = np.random.default_rng(1)
    q, v, a = rng.normal(0.0, 0.4, (3, model.nq))
    data, other = model.createData(), free.createData()
    pin.forwardKinematics(model, data, q, v, a)
    base = data.oMi[6]
    order = [list(free.names).index(name) - 2 for name in list(model.names)[7:]]
    joints = np.zeros((3, free.nv - 6))
    joints[:, order] = q[6:], v[6:], a[6:]
    flying = np.concatenate([pin.SE3ToXYZQUAT(base), joints[0]])
    torque = pin.rnea(
        free,
        other,
        flying,
        np.concatenate([data.v[6].vector, joints[1]]),
        np.concatenate([data.a[6].vector, joints[2]]),
    )
    assert pin.rnea(model, data, q, v, a)[6:] == pytest.approx(torque[6:][order])
    still = pin.rnea(model, data, q, 0 * v, 0 * a)
    assert still[:3] == pytest.approx([0.0, 0.0, 39.0 * 9.81])


def test_slopes_of_the_torques_are_exact(model) -> None:
    rng = np.random.default_rng(2)
    q, v, a = rng.normal(0.0, 0.4, (3, model.nq))
    data = model.createData()
    pin.computeRNEADerivatives(model, data, q, v, a)
    step = 1e-6 * np.eye(model.nq)
    ahead, behind = (np.stack([pin.rnea(model, model.createData(), q + s * d, v, a) for d in step]) for s in (1, -1))
    assert np.abs(data.dtau_dq.T - (ahead - behind) / 2e-6).max() < 1e-5


def test_joints_that_are_not_named_are_held_and_the_torso_is_found() -> None:
    named = tuple(name for name in NAMES if "neck" not in name)
    model = flat_model(robot_urdf().encode(), named, floating=True)
    joints = tuple(list(model.names)[7:])
    assert set(joints) == set(named)
    assert tuple(list(model.names)[1:7]) == BASE
    none = np.full(len(joints), np.inf)
    robot = MotionRobot(
        "sample", model, joints, True, JointLimits(-none, none, none, none, none),
        segments={"pelvis": "BODY", "thorax": "chest", "l_foot": "l_foot"},
    )  # fmt: skip
    assert [joints[k] for k in robot.torso] == ["torso_yaw", "torso_pitch"]
    assert len(robot.chain("pelvis", "l_foot")) == 6
    assert robot.mass == pytest.approx(39.0)
