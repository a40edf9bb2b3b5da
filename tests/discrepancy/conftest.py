"""A three-joint arm moved by pinocchio alone, with anything hidden in its torques: no code shared with the search."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin
import pytest

from exogauge.detect.pipeline import Found, find_missing_effects
from exogauge.effects.catalogue import missing_effects, shaped_effects
from exogauge.identification.identify import identify
from exogauge.identification.result import Identification
from exogauge.identification.settings import Recording, Settings
from exogauge.logs.model import Log
from exogauge.robots.description import Joint, Robot
from exogauge.robots.urdf import load_tree
from exogauge.search.search import searched as searched_for
from exogauge.search.state import Problem, Search

RATE = 200.0
JOINTS = ("j1", "j2", "j3")
SETTINGS = Settings(cutoff_hz=8.0)
FRICTION = {"k_d": np.array([0.4, 0.7, 0.3]), "tau_c": np.array([0.8, 1.2, 0.5]), "tau_o": np.array([0.2, -0.3, 0.1])}


@dataclass(frozen=True)
class Motion:
    """What a hidden effect may depend on. t: (T,). q, v, load, drive: (T, 3), drive with the known friction."""

    t: np.ndarray
    q: np.ndarray
    v: np.ndarray
    load: np.ndarray
    drive: np.ndarray


Hidden = Callable[[Motion], np.ndarray]
"""(T, 3) torque that the motors have to give beyond what the model knows."""


def nothing(motion: Motion) -> np.ndarray:
    return np.zeros_like(motion.q)


def urdf() -> bytes:
    links, previous = ['<link name="base"/>'], "base"
    for name, axis, m in zip(JOINTS, ("0 0 1", "0 1 0", "1 0 0"), (4.0, 3.0, 2.0), strict=True):
        links.append(
            f'<link name="l{name}"><inertial><origin xyz="0.06 -0.04 0.1"/><mass value="{m}"/>'
            f'<inertia ixx="{0.02 * m}" ixy="0" ixz="0" iyy="{0.025 * m}" iyz="0" izz="{0.01 * m}"/></inertial></link>'
            f'<joint name="{name}" type="revolute"><parent link="{previous}"/><child link="l{name}"/>'
            f'<origin xyz="0.05 0.02 0.25"/><axis xyz="{axis}"/>'
            '<limit lower="-3" upper="3" velocity="10" effort="100"/></joint>'
        )
        previous = f"l{name}"
    return f'<robot name="arm">{"".join(links)}</robot>'.encode()


@pytest.fixture(scope="session")
def arm_urdf() -> str:
    return urdf().decode()


@pytest.fixture(scope="session")
def robot() -> Robot:
    tree = load_tree(urdf(), joints=list(JOINTS), base_link="base", floating=False)
    return Robot("arm", tree, tuple(Joint(name, "torque") for name in JOINTS), None, (), np.eye(3))


def inverse_dynamics(q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
    """(T, 3) of an arm that is heavier than its maker says."""
    model = pin.buildModelFromXML(urdf().decode())
    for body in range(1, model.njoints):
        own = model.inertias[body]
        model.inertias[body] = pin.Inertia(
            1.15 * own.mass, own.lever + np.array([0.01, 0.01, -0.01]), 1.2 * own.inertia
        )
    data = model.createData()
    return np.array([pin.rnea(model, data, *row) for row in zip(q, v, a, strict=True)])


@pytest.fixture(scope="session")
def weighed(robot):
    """(actuation of each joint) -> the arm of `inverse_dynamics`, whose maker weighed it and measured its gains."""
    model = pin.buildModelFromXML(urdf().decode())
    phi = []
    for own in list(model.inertias)[1:]:
        true = pin.Inertia(1.15 * own.mass, own.lever + np.array([0.01, 0.01, -0.01]), 1.2 * own.inertia)
        phi.append(true.toDynamicParameters())

    def make(actuation: tuple[str, str, str] = ("torque",) * 3) -> Robot:
        joints = tuple(
            Joint(name, how, prior={"k_T": k}, prior_std={"k_T": 0.02 * k}) if how == "current" else Joint(name, how)
            for name, how, k in zip(JOINTS, actuation, (6.0, 5.0, 3.0), strict=True)
        )
        tree = replace(robot.tree, phi=np.array(phi))
        return replace(robot, tree=tree, joints=joints, inertial_std={"": 0.03})

    return make


@pytest.fixture(scope="session")
def record():
    """(seed, hidden) -> a log. Six waves per joint, so that each turns often, fast and slow; `still` never moves.
    encoder: std of a position's noise [rad]. creeps: moves by a fortieth of what it would,
    until: [s] when it begins to go to and fro at one speed, within two seconds."""

    def make(
        seed: int,
        hidden: Hidden = nothing,
        seconds: float = 30.0,
        noise: float = 0.05,
        noise_seed: int | None = None,
        still: int | None = None,
        encoder: float = 1e-5,
        creeps: int | None = None,
        until: float = np.inf,
    ) -> Log:
        rng = np.random.default_rng(seed)
        t = np.arange(0.0, seconds, 1.0 / RATE)
        omega = 2.0 * np.pi * rng.uniform(0.05, 0.7, size=(6, 3))
        size, phase = rng.uniform(0.1, 0.3, size=(6, 3)), rng.uniform(0.0, 6.28, size=(6, 3))
        if still is not None:
            size[:, still] = 0.0
        angle = t[:, None, None] * omega + phase
        q, v = np.sum(size * np.sin(angle), axis=1), np.sum(size * omega * np.cos(angle), axis=1)
        a = -np.sum(size * omega**2 * np.sin(angle), axis=1)
        if creeps is not None:
            late = 1.0 / (1.0 + np.exp(-5.0 * (t - until - 1.0)))
            v[:, creeps] = (1.0 - late) * v[:, creeps] / 40.0 + late * 0.3 * np.tanh(8.0 * np.sin(0.9 * t))
            a[:, creeps] = np.gradient(v[:, creeps], t)
            q[:, creeps] = q[0, creeps] / 40.0 + np.cumsum(v[:, creeps]) / RATE
        load = inverse_dynamics(q, v, a)
        rng = np.random.default_rng(seed + 1000 if noise_seed is None else noise_seed)
        drive = load + FRICTION["k_d"] * v + FRICTION["tau_c"] * np.sign(v) - FRICTION["tau_o"]
        tau = drive + hidden(Motion(t, q, v, load, drive)) + noise * rng.normal(size=q.shape)
        q = q + encoder * rng.normal(size=q.shape)
        channels = {f"q.{name}": q[:, j] for j, name in enumerate(JOINTS)}
        return Log(f"log{seed}", t, channels | {f"tau.{name}": tau[:, j] for j, name in enumerate(JOINTS)})

    return make


@pytest.fixture(scope="session")
def study(record):
    """(hidden) -> two logs to fit and one held out; the latter may hide something else."""

    def make(hidden: Hidden = nothing, held_out: Hidden | None = None, **how: float) -> list[Recording]:
        fitted = [Recording(record(seed, hidden, **how), False) for seed in (1, 2)]
        return [*fitted, Recording(record(9, hidden if held_out is None else held_out, **how), True)]

    return make


@pytest.fixture(scope="session")
def identified(robot):
    return lambda recordings: identify(robot, recordings, SETTINGS)


@pytest.fixture(scope="session")
def search(identified):
    """(recordings) -> what the search says, with the whole catalogue."""

    def run(recordings: list[Recording]) -> Found:
        first: Identification = identified(recordings)
        return find_missing_effects(first, recordings, tuple(shaped_effects().values()), SETTINGS)

    return run


@pytest.fixture(scope="session")
def searched(identified):
    """(recordings) -> a search on joints that has named what it names."""

    def run(recordings: list[Recording]) -> Search:
        return searched_for(Problem(identified(recordings), recordings, missing_effects(), SETTINGS))

    return run


@pytest.fixture(scope="session")
def on_joint():
    """(joint number, torque of a motion (T, 3)) -> that torque on this joint alone."""

    def only(joint: int, torque: Hidden) -> Hidden:
        return lambda motion: torque(motion) * (np.arange(3) == joint)

    return only
