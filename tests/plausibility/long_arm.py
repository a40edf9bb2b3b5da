"""An arm with the proportions of a stock one, of rods that carry each other: pan, lift, elbow and wrist."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin

from exogauge.robots.description import Robot
from exogauge.studies.intake.robot_file import load_robot

JOINTS = ("pan", "lift", "elbow", "wrist")
LINKS = ((2.0, 0.15, "0 0 1"), (3.0, 0.4, "0 1 0"), (2.0, 0.35, "0 1 0"), (0.8, 0.12, "0 1 0"))  # kg, m, axis
K_T = (8.0, 9.0, 7.0, 4.0)  # [N·m/A]
RATE = 100.0
Columns = dict[str, np.ndarray]


def urdf(rpy: tuple[float, ...] = (0.0, 0.0, 0.0)) -> str:
    """rpy: how its base is turned against the first link, which is upright."""
    text = '<robot name="long_arm"><link name="stand"/><link name="base"/><joint name="mount" type="fixed">'
    text += f'<parent link="stand"/><child link="base"/><origin rpy="{rpy[0]} {rpy[1]} {rpy[2]}"/></joint>'
    before, far = "base", "0 0 0.1"
    for name, (mass, length, axis) in zip(JOINTS, LINKS, strict=True):
        along = "0 0 {0}" if name == "pan" else "{0} 0 0"
        thin, wide = 0.002 * mass, mass * length**2 / 12.0 + 0.001 * mass
        xx, zz = (wide, thin) if name == "pan" else (thin, wide)
        inertia = f'<inertia ixx="{xx}" iyy="{wide}" izz="{zz}" ixy="0" ixz="0" iyz="0"/>'
        text += f'<link name="{name}_link"><inertial><origin xyz="{along.format(0.5 * length)}"/><mass value="{mass}"/>'
        text += f'{inertia}</inertial></link><joint name="{name}" type="revolute"><parent link="{before}"/>'
        text += f'<child link="{name}_link"/><origin xyz="{far}"/><axis xyz="{axis}"/>'
        text += '<limit lower="-3" upper="3" velocity="3" effort="150"/></joint>'
        before, far = f"{name}_link", along.format(length)
    return f"{text}</robot>"


def long_arm(folder: Path, rpy: tuple[float, ...] = (0.0, 0.0, 0.0)) -> Robot:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "robot.urdf").write_text(urdf(rpy))
    joints = "".join(
        f"  - {{name: {name}, actuation: current, prior: {{k_T: {k_T}}}}}\n"
        for name, k_T in zip(JOINTS, K_T, strict=True)
    )
    (folder / "robot.yaml").write_text(f"version: 1\nurdf: robot.urdf\nbase: fixed\njoints:\n{joints}")
    return load_robot(folder)


def record(
    seed: int, seconds: float = 20.0, rpy: tuple[float, ...] = (0.0, 0.0, 0.0), rub: float = 1.0, g: float = 9.81
) -> Columns:
    """Its bodies off by some percent, with friction of no simple law, `rub` times as much as usual."""
    rng, truth = np.random.default_rng(seed), np.random.default_rng(7)
    model = pin.buildModelFromXML(urdf(rpy))
    model.gravity.linear = np.array([0.0, 0.0, -g])
    for body in range(1, model.njoints):
        own = model.inertias[body]
        lever = own.lever * (1.0 + 0.05 * truth.standard_normal())
        model.inertias[body] = pin.Inertia(own.mass * (1.0 + 0.05 * truth.standard_normal()), lever, own.inertia)
    t, data = np.arange(0.0, seconds, 1.0 / RATE), model.createData()
    hz, phase = 0.08 * np.arange(1, 5)[:, None], rng.uniform(0.0, 2.0 * np.pi, (4, len(JOINTS)))
    size = 1.2 * rng.standard_normal((4, len(JOINTS))) / np.arange(1, 5)[:, None]
    angle = 2.0 * np.pi * hz * t[:, None, None] + phase
    q = np.sum(size * np.sin(angle), axis=1)
    dq = np.sum(size * 2.0 * np.pi * hz * np.cos(angle), axis=1)
    ddq = -np.sum(size * (2.0 * np.pi * hz) ** 2 * np.sin(angle), axis=1)
    tau = np.stack([pin.rnea(model, data, *each) for each in zip(q, dq, ddq, strict=True)])
    large = rub * np.array([2.0, 3.0, 2.0, 0.6])
    tau += large * np.tanh(dq / 0.02) + 0.5 * large * np.cbrt(dq) + 0.02 * large * ddq
    current = tau / K_T + 0.02 * rng.standard_normal(tau.shape)
    q = q + 2e-5 * rng.standard_normal(q.shape)
    columns = {f"q.{name}": q[:, j] for j, name in enumerate(JOINTS)}
    return {"t": t} | columns | {f"i.{name}": current[:, j] for j, name in enumerate(JOINTS)}
