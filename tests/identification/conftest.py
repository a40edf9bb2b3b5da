"""Logs made by pinocchio's own inverse dynamics: independent of the regressor under test."""

from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin
import pytest

from exogauge.effects.catalogue import choose
from exogauge.estimation.statistics import Statistics
from exogauge.identification.equations import Equations
from exogauge.identification.preparation import prepare
from exogauge.identification.prior import per_parameter, scales
from exogauge.identification.settings import Settings
from exogauge.identification.turns import rest_detection
from exogauge.logs.model import Log
from exogauge.robots.description import Joint, Robot, WrenchSensor
from exogauge.robots.parameters import find_base_parameters
from exogauge.robots.row_blocks import RowBlocks
from exogauge.robots.urdf import load_tree

RATE = 200.0


def chain_urdf(joints=3, seed=0):
    """A base with a chain of bodies; inertias of solid boxes, so physically possible."""
    rng = np.random.default_rng(seed)
    links, previous = [], "base"
    axes = ["0 0 1", "0 1 0", "1 0 0", "0 1 0", "0 0 1", "1 0 0"]
    for i in range(joints + 1):
        m, size = 2.0 + rng.uniform(0, 3), rng.uniform(0.08, 0.3, size=3)
        c = rng.uniform(-0.1, 0.1, size=3)
        Ixx, Iyy, Izz = (m / 12 * (size[(k + 1) % 3] ** 2 + size[(k + 2) % 3] ** 2) for k in range(3))
        name = "base" if i == 0 else f"link{i}"
        links.append(
            f'<link name="{name}"><inertial><origin xyz="{c[0]} {c[1]} {c[2]}"/><mass value="{m}"/>'
            f'<inertia ixx="{Ixx}" ixy="0" ixz="0" iyy="{Iyy}" iyz="0" izz="{Izz}"/></inertial></link>'
        )
        if i:
            links.append(
                f'<joint name="j{i}" type="revolute"><parent link="{previous}"/><child link="{name}"/>'
                f'<origin xyz="0.05 0.02 0.2"/><axis xyz="{axes[(i - 1) % 6]}"/>'
                '<limit lower="-3" upper="3" velocity="10" effort="100"/></joint>'
            )
        previous = name
    return f'<robot name="chain">{"".join(links)}</robot>'.encode()


@dataclass
class Truth:
    """What the logs were made with. phi: (N, 10). xi: name -> (J,)."""

    robot: Robot
    phi: np.ndarray
    xi: dict


def random_body(rng, phi, spread):
    """A physically possible body near phi: scaled, with a point mass added."""
    inertia = pin.Inertia.FromDynamicParameters(phi)
    m = inertia.mass
    scaled = pin.Inertia(m * np.exp(spread * rng.normal()), inertia.lever + 0.02 * spread * rng.normal(size=3),
                         inertia.inertia * np.exp(spread * rng.normal()))  # fmt: skip
    point = pin.Inertia(0.3 * spread * m * rng.uniform(), inertia.lever + 0.1 * rng.normal(size=3), np.zeros((3, 3)))
    return (scaled + point).toDynamicParameters()


@pytest.fixture
def make_truth():
    def make(floating, joints=3, seed=0, actuation="current", coupling=None):
        rng = np.random.default_rng(seed)
        names = [f"j{i + 1}" for i in range(joints)]
        tree = load_tree(chain_urdf(joints), joints=names, base_link="base", floating=floating)
        xi = {
            "k_T": rng.uniform(4, 8, joints) if actuation == "current" else np.ones(joints),
            "k_d": rng.uniform(0.2, 1.0, joints),
            "tau_c": rng.uniform(0.3, 1.5, joints),
            "tau_o": rng.normal(size=joints) * 0.3,
            "J_r": rng.uniform(0.05, 0.3, joints),
        }
        xi["tau_s"] = 1.2 * xi["tau_c"]
        described = tuple(
            Joint(name, actuation, prior={"k_T": 0.9 * k} if actuation == "current" else {})
            for name, k in zip(names, xi["k_T"], strict=True)
        )
        robot = Robot(
            "chain",
            tree,
            described,
            pin.SE3(pin.utils.rotate("x", 0.4), np.array([0.03, -0.02, 0.05])) if floating else None,
            (WrenchSensor("plate", "base", "contact", 1.0),) if floating else (),
            np.eye(joints) if coupling is None else coupling,
        )
        phi = np.array([random_body(rng, one, 0.2) for one in tree.phi])
        return Truth(robot, phi, xi)

    return make


@pytest.fixture
def stated_loads():
    """(q, v, a) -> torques (T, J) by pinocchio, of the chain as its maker states it."""

    def make(q, v, a):
        model = pin.buildModelFromXML(chain_urdf(q.shape[1]).decode())
        data = model.createData()
        return np.array([pin.rnea(model, data, *row) for row in zip(q, v, a, strict=True)])

    return make


def fourier(rng, t, width, fastest):
    """(T, width) position, rate and acceleration of a random smooth motion that begins and ends anywhere."""
    omega = 2 * np.pi * rng.uniform(0.1, fastest, size=(6, width))
    amplitude, phase = rng.uniform(0.05, 0.25, size=(6, width)), rng.uniform(0, 6.28, size=(6, width))
    angle = t[:, None, None] * omega + phase
    return (
        np.sum(amplitude * np.sin(angle), axis=1),
        np.sum(amplitude * omega * np.cos(angle), axis=1),
        -np.sum(amplitude * omega**2 * np.sin(angle), axis=1),
    )


@pytest.fixture
def make_log():
    def make(truth, seed, seconds=30.0, noise=0.0, pause=True, fastest=0.8, swing=1.0):
        rng = np.random.default_rng(seed)
        robot, J = truth.robot, len(truth.robot.joints)
        t = np.arange(0, seconds, 1 / RATE)
        clock, speed, surge = t.copy(), np.ones_like(t), np.zeros_like(t)
        if pause:  # time runs smoothly to a stop and on again, twice
            speed = 1 - sum(np.clip(1.5 - np.abs(t - c), 0, 1) ** 2 * (3 - 2 * np.clip(1.5 - np.abs(t - c), 0, 1))
                            for c in (seconds * 0.3, seconds * 0.7))  # fmt: skip
            clock = np.concatenate([[0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) / RATE)])
            surge = np.gradient(speed, 1 / RATE)
        q, dq_s, ddq_s = (swing * each for each in fourier(rng, clock, J, fastest))
        dq, ddq = dq_s * speed[:, None], ddq_s * speed[:, None] ** 2 + dq_s * surge[:, None]
        floating = robot.floating
        model = pin.buildModelFromXML(chain_urdf(J).decode(), *([pin.JointModelFreeFlyer()] if floating else []))
        first = 1 if floating else 0
        for body, one in enumerate(truth.phi):
            model.inertias[body + 1] = pin.Inertia.FromDynamicParameters(one)
        assert first == (model.njoints - 1 == len(truth.phi) and floating)
        data = model.createData()
        channels, tau, wrench = {}, np.empty((len(t), J)), np.empty((len(t), 6))
        full = (q, dq, ddq)
        if floating:
            angle, rate, acceleration = fourier(rng, t, 3, 0.7)
            shift, _, push = fourier(rng, t, 3, 0.7)
            R, w, wd = euler(angle, rate, acceleration)
            turned = [pin.Quaternion(each).coeffs() for each in R]
            pushed = np.einsum("tji,tj->ti", R, push)
            full = tuple(map(np.hstack, ((shift, turned, q), (np.zeros_like(w), w, dq), (pushed, wd, ddq))))
            R_imu, r_imu = robot.T_base_imu.rotation, robot.T_base_imu.translation
            acc, gyro = at_place(R, push + np.array([0, 0, 9.81]), w, wd, r_imu) @ R_imu, w @ R_imu
        for k, moved in enumerate(zip(*full, strict=True)):
            all_forces = pin.rnea(model, data, *moved)
            tau[k] = all_forces[-J:]
            wrench[k] = all_forces[:6] if floating else 0.0
        C = robot.axes_from_joints
        axis_dq, axis_ddq, axis_tau = dq @ C.T, ddq @ C.T, tau @ np.linalg.inv(C)
        moving = np.abs(axis_dq) > 1e-6
        stuck = truth.xi["tau_s"] * np.sign(np.sin(np.arange(J) + seed))
        friction = truth.xi["k_d"] * axis_dq + np.where(moving, truth.xi["tau_c"] * np.sign(axis_dq), stuck)
        drive = (axis_tau + friction + truth.xi["J_r"] * axis_ddq - truth.xi["tau_o"]) / truth.xi["k_T"]
        torque = robot.joints[0].actuation == "torque"
        logged = drive @ C if torque else drive
        kinds = [("q", q, 1e-5), ("tau" if torque else "i", logged, 0.1 if torque else 0.02)]
        for kind, values, std in kinds:
            for j, joint in enumerate(robot.joints):
                channels[f"{kind}.{joint.name}"] = values[:, j] + noise * std * rng.normal(size=len(t))
        if floating:
            for i, axis in enumerate("xyz"):
                channels[f"acc.{axis}"] = acc[:, i] + noise * 0.03 * rng.normal(size=len(t))
                channels[f"gyro.{axis}"] = gyro[:, i] + noise * 0.003 * rng.normal(size=len(t))
                channels[f"ft.plate.f{axis}"] = wrench[:, i] + noise * 0.5 * rng.normal(size=len(t))
                channels[f"ft.plate.m{axis}"] = wrench[:, 3 + i] + noise * 0.05 * rng.normal(size=len(t))
        return Log(f"log{seed}", t, channels)

    return make


def euler(angle, rate, acceleration):
    """(T, 3) each -> (T, 3, 3) Rz Ry Rx (world from base), (T, 3) angular velocity and acceleration in the base."""
    R = np.array([pin.rpy.rpyToMatrix(*each) for each in angle])
    (sx, sy), (cx, cy) = np.sin(angle.T[:2]), np.cos(angle.T[:2])
    (x, y, z), (ddx, ddy, ddz) = rate.T, acceleration.T
    w = np.column_stack([x - sy * z, cx * y + cy * sx * z, cy * cx * z - sx * y])
    turning = (
        -cy * y * z,
        -sx * x * y + (cy * cx * x - sy * y * sx) * z,
        -cx * x * y - (sy * y * cx + cy * sx * x) * z,
    )
    own = [ddx - sy * ddz, cx * ddy + cy * sx * ddz, cy * cx * ddz - sx * ddy]
    return R, w, np.column_stack(own) + np.column_stack(turning)


def at_place(R, up, w, wd, r):
    """(T, 3) what an accelerometer at r of a body feels, in its axes. up: (3,) or (T, 3) acceleration of its origin
    less gravity, in the world."""
    felt = np.einsum("tji,tj->ti", R, np.broadcast_to(up, w.shape))
    return felt + np.cross(wd, r) + np.cross(w, np.cross(w, r))


@pytest.fixture
def with_prior_std():
    """The same truth with a robot whose stated spreads are `relative` of the true values' size."""

    def widen(truth, **std):
        joints = tuple(replace(joint, prior_std=std) for joint in truth.robot.joints)
        return Truth(replace(truth.robot, joints=joints), truth.phi, truth.xi)

    return widen


@pytest.fixture
def small(make_truth, make_log):
    """(equations, prepared log, prior) of a fixed arm whose torques are logged."""
    truth = make_truth(False, joints=2, actuation="torque")
    log = make_log(truth, seed=1, seconds=8.0, noise=1.0)
    base = find_base_parameters(truth.robot.tree)
    rows = RowBlocks(truth.robot.tree, base, truth.robot.axes_from_joints)
    equations = Equations(truth.robot, rows, base, choose(Settings().effects))
    prepared = prepare(truth.robot, log, 10.0, rest_detection(truth.robot, [log], 10.0))
    return equations, prepared, per_parameter(truth.robot, base, equations.effects, scales(truth.robot, [prepared]))


@pytest.fixture
def statistics_for(small):
    """Of the rows of `small`'s log, with the right-hand side that the parameters x would give."""
    equations, prepared, _ = small

    def make(x):
        made = Statistics.empty(equations.size, equations.columns())
        for _, chunks in equations.rows(prepared, np.zeros(equations.size)):
            for chunk in chunks:
                block = chunk.block.copy(order="F")
                block[:, -1] = block[:, :-1] @ x[equations.columns()[chunk.kind]]
                made.add_rows(chunk.kind, block)
        return made

    return make
