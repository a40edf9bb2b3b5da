"""What one joint lacks is not given to a sensor under a foot, whose zero or gain moves every joint a little.

Two legs of one joint each and an arm, made by pinocchio without our code; the trunk sways, the feet go with it.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from tests.discrepancy.test_sensor_effects import searched

from exogauge.logs.model import Log
from exogauge.robots.description import Joint, Robot, WrenchSensor
from exogauge.robots.urdf import load_tree

pytestmark = pytest.mark.slow

JOINTS, FEET, AXES = ("arm", "left_leg", "right_leg"), ("left", "right"), ("fx", "fy", "fz", "mx", "my", "mz")
RATE, SECONDS = 200.0, 30.0


def urdf() -> str:
    def link(name: str, mass: float, z: float) -> str:
        return (
            f'<link name="{name}"><inertial><origin xyz="0.02 0.01 {z}"/><mass value="{mass}"/>'
            f'<inertia ixx="{0.02 * mass}" ixy="0" ixz="0" iyy="{0.025 * mass}" iyz="0" izz="{0.01 * mass}"/>'
            "</inertial></link>"
        )

    def joint(name: str, child: str, place: str, axis: str) -> str:
        return (
            f'<joint name="{name}" type="revolute"><parent link="trunk"/><child link="{child}"/>'
            f'<origin xyz="{place}"/><axis xyz="{axis}"/>'
            '<limit lower="-3" upper="3" velocity="10" effort="300"/></joint>'
        )

    parts = [link("trunk", 14.0, 0.15), link("reach", 3.0, -0.15), joint("arm", "reach", "0 -0.2 0.3", "0 1 0")]
    for side, y in (("left", 0.1), ("right", -0.1)):
        parts += [link(f"{side}_shank", 3.0, -0.2), joint(f"{side}_leg", f"{side}_shank", f"0 {y} 0", "0 1 0")]
        parts.append(
            f'<link name="{side}"/><joint name="{side}_sole" type="fixed"><parent link="{side}_shank"/>'
            f'<child link="{side}"/><origin xyz="0 0 -0.4"/></joint>'
        )
    return f'<robot name="walker">{"".join(parts)}</robot>'


@pytest.fixture(scope="module")
def robot() -> Robot:
    tree = load_tree(urdf().encode(), joints=list(JOINTS), base_link="trunk", floating=True, cut_frames=FEET)
    sensors = tuple(WrenchSensor(name, name, "contact", 1.0) for name in FEET)
    joints = tuple(Joint(name, "torque") for name in JOINTS)
    return Robot("walker", tree, joints, pin.SE3.Identity(), sensors, np.eye(3), inertial_std={"": 0.2})


def waves(rng: np.random.Generator, t: np.ndarray, size: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Angle, velocity, acceleration."""
    omega, phase, part = 2.0 * np.pi * rng.uniform(0.08, 0.7, 5), rng.uniform(0.0, 6.28, 5), rng.uniform(0.4, 1.0, 5)
    angle, part = np.outer(t, omega) + phase, size * part / part.sum()
    return np.sin(angle) @ part, np.cos(angle) @ (part * omega), -np.sin(angle) @ (part * omega**2)


def record(seed: int, of_arm: float, zero: float, slower: float = 1.0, alike: bool = False, aside: bool = False) -> Log:
    """of_arm: share of the arm's torque that is read at the left leg, too. zero: of the left foot along y [N]. slower:
    times as usual. alike: both legs move so, and little of the load goes from one foot to the other. aside: the left
    foot bears little."""
    model = pin.buildModelFromXML(urdf(), pin.JointModelFreeFlyer())
    data, rng = model.createData(), np.random.default_rng(seed)
    for body in range(1, model.njoints):
        own = model.inertias[body]
        model.inertias[body] = pin.Inertia(1.1 * own.mass, own.lever + np.array([0.01, -0.01, 0.0]), own.inertia)
    soles = [model.getFrameId(name) for name in FEET]
    t = np.arange(0.0, SECONDS, 1.0 / RATE)
    joints, about = ([waves(rng, t / slower, size) for size in sizes] for sizes in ((1.0, 0.6, 0.6), (0.15, 0.2)))
    joints = [*joints[:2], joints[1]] if alike else joints
    joints, about = ([(q, v / slower, a / slower**2) for q, v, a in some] for some in (joints, about))
    about_x, about_y = about
    borne, pushed = (
        (0.12 if aside else 0.5) + waves(rng, t, 0.04 if alike or aside else 0.35)[0],
        10.0 * waves(rng, t, 1.0)[0],
    )
    friction = (np.array([0.3, 0.5, 0.6]), np.array([0.4, 0.8, 1.0]))
    rows = []
    for k in range(len(t)):
        # the trunk turns about the world's y, then about its own x, at one place
        R = pin.rpy.rpyToMatrix(about_x[0][k], about_y[0][k], 0.0)
        x = np.array([1.0, 0.0, 0.0])
        y = pin.rpy.rpyToMatrix(about_x[0][k], 0.0, 0.0).T @ np.array([0.0, 1.0, 0.0])
        turn = about_x[1][k] * x + about_y[1][k] * y
        faster = about_x[2][k] * x + about_y[2][k] * y - about_x[1][k] * about_y[1][k] * np.cross(x, y)
        q = np.concatenate([np.zeros(3), pin.Quaternion(R).coeffs(), [each[0][k] for each in joints]])
        v = np.concatenate([np.zeros(3), turn, [each[1][k] for each in joints]])
        a = np.concatenate([np.zeros(3), faster, [each[2][k] for each in joints]])
        asked = pin.rnea(model, data, q, v, a)
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        whole = data.oMi[1].act(pin.Force(asked[:6]))
        read, tau = [], asked[6:].copy()
        for sole, part in zip(soles, (borne[k], 1.0 - borne[k]), strict=True):
            push = pin.Force(np.array([0.0, pushed[k] if sole == soles[0] else -pushed[k], 0.0]), np.zeros(3))
            wrench = data.oMf[sole].actInv(pin.Force(part * whole.vector) + push)
            tau -= pin.getFrameJacobian(model, data, sole, pin.LOCAL)[:, 6:].T @ wrench.vector
            read.append(wrench.vector)
        felt = R.T @ np.array([0.0, 0.0, 9.81])
        rows.append(
            np.concatenate([q[7:], tau + friction[0] * v[6:] + friction[1] * np.sign(v[6:]), felt, turn, *read])
        )
    table, noise = np.array(rows), rng.standard_normal
    table[:, 4] += of_arm * table[:, 3]
    table[:, 12 + 1] += zero
    size = [*[1e-5] * 3, *[0.05] * 3, *[0.02] * 3, *[0.001] * 3, *[*[0.3] * 3, *[0.03] * 3] * 2]
    table += noise(table.shape) * np.array(size)
    names = [*(f"q.{name}" for name in JOINTS), *(f"tau.{name}" for name in JOINTS),
             *(f"acc.{axis}" for axis in "xyz"), *(f"gyro.{axis}" for axis in "xyz"),
             *(f"ft.{foot}.{axis}" for foot in FEET for axis in AXES)]  # fmt: skip
    return Log(f"log{seed}", t, dict(zip(names, table.T, strict=True)))


@pytest.mark.parametrize(("of_arm", "zero"), [(0.0, 0.0), (0.12, 0.0), (0.12, 6.0)])
def test_a_foot_is_named_for_what_it_has_wrong_alone(robot: Robot, of_arm: float, zero: float) -> None:
    found = searched(robot, [record(seed, of_arm, zero) for seed in (1, 2, 3)]).discrepancy
    named = [(each.effect, each.place.name, each.place.part) for each in found.findings]
    assert named == ([("ft_zero", "left", "fy")] if zero else [])
    assert [each.channel for each in found.unexplained] == (["tau.left_leg"] if of_arm else [])
