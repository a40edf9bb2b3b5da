"""A plain study on disk: rigid bodies by MuJoCo, viscous and Coulomb friction, white noise, and nothing else.

Shares no code with what evaluates it. What was drawn goes to truth.json beside the study.
"""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

import mujoco
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray
from tests.plain.excitation import STYLES
from tests.plain.stock_robots import ROBOTS, StockRobot

Array = NDArray[np.float64]

LOGS = (("id_1", 48.0, "identification"), ("id_2", 48.0, "identification"), ("val_1", 36.0, "validation"))
RATES_HZ = (125.0, 250.0, 500.0)
ENCODER, CURRENT, TORQUE, FORCE, MOMENT, ACC, GYRO = 2e-5, 0.02, 0.1, 1.0, 0.1, 0.02, 0.002  # std of the noise
MASS_STD = 0.1  # relative, of what is stated; drawn
GAIN_STD = 0.1  # the same of k_T
SOFT = 0.02  # [rad/s] over which friction turns round in every fourth study (tanh), 0: at once


@final
@dataclass(frozen=True)
class Plan:
    """What a seed stands for."""

    seed: int
    robot: StockRobot
    style: str
    rate_hz: float
    actuation: str
    soft: float

    @property
    def name(self) -> str:
        return f"{self.seed:04d}-{self.robot.name}-{self.style}-{self.rate_hz:.0f}Hz-{self.actuation}" + (
            "-soft" if self.soft else ""
        )


def plan(seed: int) -> Plan:
    """Styles by turns, then robots, twenty seeds a round; rates and actuation by other counts, so that all meet all."""
    styles = tuple(STYLES)
    robot = ROBOTS[(seed // len(styles)) % len(ROBOTS)]
    return Plan(
        seed,
        robot,
        styles[seed % len(styles)],
        200.0 if robot.base_link else RATES_HZ[(seed + seed // 4) % 3],
        "current" if (seed // 2 + seed // 20) % 2 else "torque",
        SOFT if seed % 8 in (3, 4) else 0.0,
    )


def write_study(folder: Path, what: Plan) -> None:
    """study.yaml, robot.yaml, robot.urdf, logs/ into `folder`, and truth.json."""
    rng = np.random.default_rng([what.seed, 7])
    stated = what.robot.tree()
    (folder / "logs").mkdir(parents=True)
    (folder / "robot.urdf").write_bytes(ET.tostring(stated))
    model = _compiled(stated, what.robot)
    names = [model.joint(j).name for j in range(model.njnt) if model.joint(j).type == mujoco.mjtJoint.mjJNT_HINGE]
    _draw_bodies(model, rng)
    J = len(names)
    k_T = rng.uniform(0.5, 2.0, J) * 10.0 if what.actuation == "current" else np.ones(J)
    torque = _largest_torque(model, names)
    truth = {
        "k_T": k_T,
        "k_d": rng.uniform(0.02, 0.1, J) * torque,
        "tau_c": rng.uniform(0.03, 0.1, J) * torque,
    }
    stated_k_T = k_T * (1.0 + GAIN_STD * rng.normal(size=J))
    logs = []
    for name, lasts, role in LOGS:
        table = _log(model, names, what, truth, np.arange(round(lasts * what.rate_hz)) / what.rate_hz, rng)
        pq.write_table(pa.table(table), folder / "logs" / f"{name}.parquet")
        logs.append({"file": f"logs/{name}.parquet", "role": role})
    joints = [
        {"name": name, "actuation": what.actuation}
        | (
            {"prior": {"k_T": round(float(stated), 4)}, "prior_std": {"k_T": round(GAIN_STD * float(stated), 4)}}
            if what.actuation == "current"
            else {}
        )
        for name, stated in zip(names, stated_k_T, strict=True)
    ]
    robot: dict[str, Any] = {"version": 1, "uncertainty": "none", "urdf": "robot.urdf", "joints": joints}
    robot["inertial_prior_std"] = {"default": MASS_STD}
    if what.robot.base_link:
        robot |= {
            "base": "floating",
            "base_link": what.robot.base_link,
            "imu": {"parent": what.robot.base_link, "xyz": [0, 0, 0], "rpy": [0, 0, 0]},
            "ft_sensors": [
                {"name": foot, "frame": foot, "role": "contact", "sees": "world_on_robot"} for foot in what.robot.feet
            ],
        }
    else:
        robot["base"] = "fixed"
    study = {"version": 1, "name": f"Plain {what.name} (synthetic)", "robot": "robot.yaml", "logs": logs}
    (folder / "robot.yaml").write_text(json.dumps(robot, indent=1))  # JSON is YAML
    (folder / "study.yaml").write_text(json.dumps(study, indent=1))
    (folder / "truth.json").write_text(
        json.dumps({key: dict(zip(names, map(float, values), strict=True)) for key, values in truth.items()})
    )


def _compiled(urdf: ET.Element, robot: StockRobot) -> mujoco.MjModel:
    """With a free joint at the base where the robot floats; friction and armature are added outside."""
    spec = mujoco.MjSpec.from_string(ET.tostring(urdf, encoding="unicode"))
    spec.compiler.fusestatic = False
    spec.compiler.balanceinertia = True
    if robot.base_link:
        spec.worldbody.first_body().add_freejoint()
    model = spec.compile()
    model.dof_damping[:], model.dof_frictionloss[:], model.dof_armature[:] = 0.0, 0.0, 0.0
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    return model


def _draw_bodies(model: mujoco.MjModel, rng: np.random.Generator) -> None:
    """True bodies: as the URDF states them, but for a factor on all of each."""
    factor = 1.0 + MASS_STD * rng.normal(size=model.nbody)
    model.body_mass[:] *= factor
    model.body_inertia[:] *= factor[:, None]
    mujoco.mj_setConst(model, mujoco.MjData(model))


def _largest_torque(model: mujoco.MjModel, names: list[str]) -> Array:
    """(J,) [N·m] a size for friction: gravity's at random postures, at least a few."""
    rng, data = np.random.default_rng(0), mujoco.MjData(model)
    seen = []
    for _ in range(50):
        data.qpos[:] = model.qpos0
        data.qpos[-len(names) :] = rng.uniform(-1.0, 1.0, len(names))
        mujoco.mj_inverse(model, data)
        seen.append(data.qfrc_inverse[-len(names) :].copy())
    return np.asarray(np.clip(np.abs(seen).max(axis=0), 8.0, 80.0))


def _log(
    model: mujoco.MjModel, names: list[str], what: Plan, truth: dict[str, Array], time: Array, rng: np.random.Generator
) -> dict[str, Array]:
    J, T = len(names), len(time)
    q, dq, ddq = np.zeros((3, T, J))
    for j, name in enumerate(names):
        low, high = model.joint(name).range
        low, high = (low, high) if high > low else (-3.0, 3.0)
        middle = what.robot.posture.get(name, 0.5 * (max(low, -3.0) + min(high, 3.0)))
        q[:, j] = middle
        if not name.startswith(what.robot.still or ("-",)):
            room = 0.9 * min(middle - max(low, -3.0), min(high, 3.0) - middle, 1.4)
            wave = STYLES[what.style](rng, time, rng.uniform(0.6, 1.0) * room)
            q[:, j], dq[:, j], ddq[:, j] = middle + wave[0], wave[1], wave[2]
    data, torque = mujoco.MjData(model), np.empty((T, J))
    columns: dict[str, Array] = {"t": time}
    first = 6 if what.robot.base_link else 0
    feet = [model.body(foot).id for foot in what.robot.feet]
    wrenches = np.zeros((T, len(feet), 6))
    for t in range(T):
        data.qpos[:] = model.qpos0
        data.qpos[-J:], data.qvel[-J:], data.qacc[-J:] = q[t], dq[t], ddq[t]
        mujoco.mj_inverse(model, data)
        needed = data.qfrc_inverse.copy()
        if feet:
            needed, wrenches[t] = _stand(model, data, needed, feet, t)
        torque[t] = needed[first:]
    sign = np.tanh(dq / what.soft) if what.soft else np.sign(dq)
    torque += truth["k_d"] * dq + truth["tau_c"] * sign
    for j, name in enumerate(names):
        columns[f"q.{name}"] = q[:, j] + ENCODER * rng.normal(size=T)
        if what.actuation == "current":
            columns[f"i.{name}"] = torque[:, j] / truth["k_T"][j] + CURRENT * rng.normal(size=T)
        else:
            columns[f"tau.{name}"] = torque[:, j] + TORQUE * rng.normal(size=T)
    if feet:
        for axis, up in zip("xyz", (0.0, 0.0, 9.81), strict=True):
            columns[f"acc.{axis}"] = up + ACC * rng.normal(size=T)
            columns[f"gyro.{axis}"] = GYRO * rng.normal(size=T)
        for foot, wrench in zip(what.robot.feet, np.moveaxis(wrenches, 1, 0), strict=True):
            for k, axis in enumerate(("fx", "fy", "fz", "mx", "my", "mz")):
                columns[f"ft.{foot}.{axis}"] = wrench[:, k] + (FORCE if k < 3 else MOMENT) * rng.normal(size=T)
    return columns


def _stand(model: mujoco.MjModel, data: mujoco.MjData, needed: Array, feet: list[int], t: int) -> tuple[Array, Array]:
    """(V,) what the motors give when the feet hold the base, and (S, 6) the wrench on each foot, in its frame.

    Both feet bear what the base needs by a share that sways slowly, at the same time along all six axes.
    """
    share = 0.5 + 0.2 * np.sin(0.003 * t)
    jacobians = []
    for foot in feet:
        J_p, J_r = np.zeros((2, 3, model.nv))
        mujoco.mj_jac(model, data, J_p, J_r, data.xpos[foot], foot)
        jacobians.append(np.vstack([J_p, J_r]))
    wrenches = []
    left = needed.copy()
    for J, part, foot in zip(jacobians, (share, 1.0 - share), feet, strict=True):
        wrench = np.linalg.solve(J[:, :6].T, part * needed[:6])  # world axes, at the foot's origin
        left -= J.T @ wrench
        R = data.xmat[foot].reshape(3, 3)
        wrenches.append(np.concatenate([R.T @ wrench[:3], R.T @ wrench[3:]]))
    return left, np.array(wrenches)
