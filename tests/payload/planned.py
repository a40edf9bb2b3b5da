"""The generator's arm, as planning sees it."""

from __future__ import annotations

import numpy as np
import yaml
from numpy.typing import NDArray
from tests.payload.conftest import GRAVITY, STD, generator

from exogauge.payload.dynamics import Prior, static_prior
from exogauge.payload.planning.arm import Arm, Component
from exogauge.payload.planning.excitation import Series, Task
from exogauge.payload.planning.workspace import Cap
from exogauge.robots.joint_limits import JointLimits

Array = NDArray[np.float64]

COMPONENT = Component(40.0, np.array([0.01, -0.02, 0.03]), np.array([1.1, 0.4, 0.1]))


def arm_of(moved: tuple[str, ...] = generator.JOINTS[3:], urdf: str | None = None) -> Arm:
    return Arm(
        (urdf or generator.arm_urdf()).encode(), generator.JOINTS, "base", "ft", GRAVITY, COMPONENT, moved,
        generator.WORK,
    )  # fmt: skip


def wrist_limits() -> JointLimits:
    return JointLimits(
        np.full(6, -2.8), np.full(6, 2.8), np.full(6, 1.6), np.full(6, 6.0),
        np.array([3000.0, 3000.0, 3000.0, 600.0, 600.0, 300.0]),
    )  # fmt: skip


def task_of(prior: Prior | None = None, moved: tuple[str, ...] = generator.JOINTS[3:]) -> Task:
    return Task(
        arm_of(moved), Series(10.0, 5), wrist_limits(), (Cap(2, theta=(np.radians(120.0), np.pi)),), -1, STD, 250.0,
        prior or static_prior(None), np.array([2500.0, 2500.0, 6250.0, 400.0, 400.0, 400.0]),
    )  # fmt: skip


def plan_yaml(**changes: object) -> str:
    """payload.yaml without logs; `changes` replace keys of `plan`, None takes one out."""
    file = generator.payload_file(0)
    del file["logs"], file["ground_truth"]
    plan: dict[str, object] = {
        "joints": ["a4", "a5", "a6"],
        "home": {name: float(x) for name, x in zip(generator.JOINTS, generator.WORK, strict=True)},
        "acceleration": {"a4": 6.0, "a5": 6.0, "a6": 9.0},
        "velocity": {"a4": 1.6, "a5": 1.6, "a6": 2.4},
        "position": {name: [-2.8, 2.8] for name in ("a4", "a5", "a6")},
        "payload": {"mass_kg": 40.0, "centre_m": [0.0, 0.0, 0.02], "size_m": [1.1, 0.4, 0.1]},
        "workspace": [{"axis": "z", "theta_deg": [120.0, 180.0]}],
        "excitation": {"starts": 1},
    }
    plan |= changes
    file["plan"] = {key: value for key, value in plan.items() if value is not None}
    return str(yaml.safe_dump(file, sort_keys=False))
