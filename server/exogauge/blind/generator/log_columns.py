"""One log as the robot would have stored it: the contract's columns, every sensor with its own error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from exogauge.blind.generator import sensors
from exogauge.blind.generator.axis_run import AxisRun
from exogauge.blind.generator.cut import AXES
from exogauge.blind.generator.motion import Motion
from exogauge.blind.generator.plan import CasePlan
from exogauge.blind.generator.robot_kind import WristOrBase
from exogauge.synthetic.robot_facts import Joint

Array = NDArray[np.float64]


def joint_columns(
    rng: np.random.Generator,
    plan: CasePlan,
    joints: Sequence[Joint],
    motion: Motion,
    runs: Sequence[AxisRun],
    torques: Sequence[Array],
    log: int,
) -> dict[str, Array]:
    """Angles, currents or torques, temperatures. torques: (L, T) each, k_T i."""
    q = {f"q.{j.name}": sensors.encoder(rng, motion.q[log, :, n], j.drive.gear_ratio) for n, j in enumerate(joints)}
    logged: dict[str, Array] = {}
    for joint, run, torque in zip(joints, runs, torques, strict=True):
        current = sensors.current(rng, torque[log] / run.drive.k_T)
        if plan.actuation == "current":
            logged[f"i.{joint.name}"] = current
        else:  # a drive that knows its own constant
            logged[f"tau.{joint.name}"] = current * run.drive.k_T
    if plan.temperature:
        for joint, run in zip(joints, runs, strict=True):
            logged[f"temp.{joint.name}"] = sensors.thermometer(rng, run.temperature[log])
    return {**q, **logged}


def sensor_columns(
    rng: np.random.Generator, sensor: WristOrBase, wrench: Array, zero: Array, log: int
) -> dict[str, Array]:
    """Force, then moment, with the sensor's zero error (6,); wrench: (L, T, 6)."""
    felt, std = wrench[log] + zero, np.repeat([sensor.force, sensor.moment], 3)
    return {f"ft.{sensor.name}.{axis}": sensors.noisy(rng, felt[:, n], float(std[n])) for n, axis in enumerate(AXES)}


def table(time: Array, columns: Mapping[str, Array]) -> pa.Table:
    """Angles in double precision, what carries more noise in single."""
    exact = {name: pa.array(values) for name, values in columns.items() if name.startswith("q.")}
    rest = {name: pa.array(v.astype(np.float32)) for name, v in columns.items() if not name.startswith("q.")}
    return pa.table({"t": pa.array(time), **exact, **rest})
