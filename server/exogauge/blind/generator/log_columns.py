"""One log as the robot would have stored it: the contract's columns, every sensor with its own error.

What carries noise is stored in single precision.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from exogauge.blind.generator import sensors
from exogauge.blind.generator.axis_run import AxisRun
from exogauge.blind.generator.dynamics import GRAVITY, inverse_dynamics
from exogauge.blind.generator.motion import Motion
from exogauge.blind.generator.plan import CasePlan
from exogauge.blind.generator.robot_kind import Mount
from exogauge.blind.generator.true_robot import TrueRobot
from exogauge.synthetic.robot_facts import Joint, Link

Array = NDArray[np.float64]


def joint_columns(
    rng: np.random.Generator,
    plan: CasePlan,
    joints: Sequence[Joint],
    motion: Motion,
    runs: Sequence[AxisRun],
    torques: Sequence[Array],
    log: int,
) -> dict[str, pa.Array]:
    """Time, angles, currents or torques, temperatures. torques: (L, T) each, k_T i."""
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
    return {"t": pa.array(motion.time), **{name: pa.array(values) for name, values in q.items()}, **_singles(logged)}


def mount_columns(
    rng: np.random.Generator, mount: Mount, links: Sequence[Link], robot: TrueRobot, motion: Motion, log: int
) -> dict[str, pa.Array]:
    """IMU of the still base, and the wrench on it at the sensor; both frames are parallel to the base's."""
    place = next(np.array(link.origin) for link in links if link.name == mount.sensor)
    _, carried = inverse_dynamics(robot.tree, robot.phi, motion.q[log], motion.dq[log], motion.ddq[log])
    weight = np.array([0.0, 0.0, GRAVITY * robot.base.mass])
    force = carried[:, :3] + weight
    moment = carried[:, 3:] + np.cross(robot.base.centre, weight) - np.cross(place, force)
    still, upwards = np.zeros((len(motion.time), 3)), np.tile([0.0, 0.0, GRAVITY], (len(motion.time), 1))
    logged: dict[str, Array] = {}
    for kind, values in (("acc", upwards), ("gyro", still)):
        logged |= {f"{kind}.{axis}": sensors.noisy(rng, values[:, n], kind) for n, axis in enumerate("xyz")}
    for kind, letter, values in (("force", "f", force), ("moment", "m", moment)):
        logged |= {
            f"ft.{mount.sensor}.{letter}{axis}": sensors.noisy(rng, values[:, n], kind) for n, axis in enumerate("xyz")
        }
    return _singles(logged)


def _singles(logged: Mapping[str, Array]) -> dict[str, pa.Array]:
    return {name: pa.array(values.astype(np.float32)) for name, values in logged.items()}
