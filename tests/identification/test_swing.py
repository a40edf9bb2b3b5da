"""Inertia and gravity's slope about each axis, against pinocchio's mass matrix and gravity."""

import numpy as np
import pinocchio as pin
import pytest

from exogauge.effects.catalogue import choose
from exogauge.identification.axis_signals import inertia_and_slope
from exogauge.identification.equations import Equations
from exogauge.identification.settings import Settings
from exogauge.robots.description import Joint, Robot
from exogauge.robots.motion import Motion
from exogauge.robots.parameters import find_base_parameters
from exogauge.robots.row_blocks import RowBlocks
from exogauge.robots.urdf import load_tree

JOINTS = ("a", "b", "c")
G = np.array([0.0, 0.0, 9.81])


def urdf() -> bytes:
    links, previous = ['<link name="base"/>'], "base"
    for name, axis, mass in zip(JOINTS, ("0 1 0", "1 0 0", "0 1 0"), (3.0, 2.0, 1.5), strict=True):
        links.append(
            f'<link name="l_{name}"><inertial><origin xyz="0.05 -0.03 0.2"/><mass value="{mass}"/>'
            f'<inertia ixx="{0.02 * mass}" ixy="0.001" ixz="0" iyy="{0.03 * mass}" iyz="0" izz="{0.025 * mass}"/>'
            f'</inertial></link><joint name="{name}" type="revolute"><parent link="{previous}"/>'
            f'<child link="l_{name}"/><origin xyz="0.02 0.01 0.3"/><axis xyz="{axis}"/>'
            '<limit lower="-3" upper="3" velocity="9" effort="99"/></joint>'
        )
        previous = f"l_{name}"
    return f'<robot name="arm">{"".join(links)}</robot>'.encode()


@pytest.mark.parametrize("mixed", [False, True], ids=["own motors", "coupled motors"])
def test_they_are_those_of_the_links_beyond_each_axis(mixed):
    tree = load_tree(urdf(), joints=list(JOINTS), base_link="base", floating=False)
    C = np.eye(3)
    if mixed:
        C[2, 1] = 0.5
    robot = Robot("arm", tree, tuple(Joint(name, "torque") for name in JOINTS), None, (), C)
    base = find_base_parameters(tree)
    equations = Equations(robot, RowBlocks(tree, base, C), base, choose(Settings().effects))
    q = np.random.default_rng(4).uniform(-1.5, 1.5, (7, 3))
    none = np.zeros((7, 3))
    motion = Motion(q, 0.0 * q, 0.0 * q, np.tile(G, (7, 1)), none, none)
    inertia, slope = inertia_and_slope(equations, base.regroup @ tree.phi.ravel(), motion)
    model = pin.buildModelFromXML(urdf().decode())
    data, turns = model.createData(), np.linalg.inv(C)
    for posture, J, K in zip(q, inertia, slope, strict=True):
        M = pin.crba(model, data, posture)
        M = np.triu(M) + np.triu(M, 1).T
        stiffness = pin.computeGeneralizedGravityDerivatives(model, data, posture)
        np.testing.assert_allclose(J, np.diag(turns.T @ M @ turns), rtol=1e-9)
        np.testing.assert_allclose(K, np.diag(turns.T @ stiffness @ turns), rtol=1e-9, atol=1e-9)
