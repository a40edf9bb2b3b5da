"""Logs of a one-joint arm with and without an elastic strap, from closed formulas: its truth is known."""

from __future__ import annotations

from pathlib import Path

import numpy as np

STIFFNESS, NATURAL_LENGTH = 200.0, 0.25  # [N/m], [m]
MASS, LEVER, INERTIA = 2.0, 0.1, 0.04  # [kg], [m], [kg·m²] about the joint
DEVICE = f"""version: 1
name: Elbow strap
bands:
  - name: front
    via_points: [{{link: base, xyz: [0.05, 0, 0]}}, {{link: arm, xyz: [0.05, 0, 0.1]}}]
    stiffness_n_per_m: {STIFFNESS}
    natural_length_m: {NATURAL_LENGTH}
    ground_truth: true
"""
STUDY = """version: 1
name: Worn arm
robot: robot.yaml
device: device.yaml
logs:
  - {file: logs/id.csv, role: identification}
  - {file: logs/val.csv, role: validation}
  - {file: logs/plain.csv, role: without_device, motion: bend}
  - {file: logs/worn.csv, role: with_device, motion: bend}
settings: {cutoff_hz: 8}
"""


def write_worn_study(folder: Path, robot_yaml: str, urdf: str, *, same_motion: bool = True) -> Path:
    """A complete study; with `same_motion=False` the arm bends twice as fast with the strap as without."""
    rich, other, bend = ((0.9, 0.31, 0.5, 0.83), (0.8, 0.27, 0.6, 0.71), (0.8, 0.1, 0.1, 0.37))
    worn = bend if same_motion else (0.8, 0.2, 0.1, 0.37)
    texts = {"study.yaml": STUDY, "device.yaml": DEVICE, "robot.yaml": robot_yaml, "robot.urdf": urdf}
    logs = {"id": (rich, False), "val": (other, False), "plain": (bend, False), "worn": (worn, True)}
    for seed, (name, (motion, strapped)) in enumerate(logs.items()):
        texts[f"logs/{name}.csv"] = table(motion, strapped, seed)
    for path, text in texts.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(text)
    return folder


def table(motion: tuple[float, float, float, float], strapped: bool, seed: int) -> str:
    """20 s at 100 Hz. motion: amplitude [rad] and frequency [Hz] of two sines."""
    rng = np.random.default_rng(seed)
    t = np.arange(2000) / 100.0
    q, dq, ddq = np.zeros((3, len(t)))
    for amplitude, rate in (motion[:2], motion[2:]):
        w = 2.0 * np.pi * rate
        q += amplitude * np.sin(w * t)
        dq += amplitude * w * np.cos(w * t)
        ddq -= amplitude * w**2 * np.sin(w * t)
    tau = INERTIA * ddq - MASS * 9.80665 * LEVER * np.sin(q) + 0.2 * dq + 0.1 * np.sign(dq)
    if strapped:
        tau -= strap_torque(q)
    q += 1e-5 * rng.standard_normal(len(t))
    tau += 0.01 * rng.standard_normal(len(t))
    rows = [f"{a:.2f},{b:.7f},{c:.5f}" for a, b, c in zip(t, q, tau, strict=True)]
    return "\n".join(["t,q.elbow,tau.elbow", *rows]) + "\n"


def strap_torque(q: np.ndarray) -> np.ndarray:
    """On the joint, about y: tension times the lever of its line. (T,) [N·m]"""
    x, z = 0.05 * np.cos(q) + 0.1 * np.sin(q), 0.1 * np.cos(q) - 0.05 * np.sin(q)  # arm's point, from the joint
    along = np.array([0.05 - x, -0.2 - z])  # to the base's point
    length = np.linalg.norm(along, axis=0)
    tension = STIFFNESS * np.maximum(length - NATURAL_LENGTH, 0.0)
    torque: np.ndarray = tension * (z * along[0] - x * along[1]) / length
    return torque
