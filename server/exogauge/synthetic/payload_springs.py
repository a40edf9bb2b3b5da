"""A payload of which all, or a part, hangs on springs: it gives way, swings and comes back."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

Array = NDArray[np.float64]

SUBSTEPS = 4  # of one sample: the springs swing at a few hertz
SETTLING = 30  # passes to the posture in which springs and weight agree


@final
@dataclass(frozen=True)
class Hung:
    """mass [kg], centre (3,) [m] and inertia (3, 3) [kg·m²] about it of what hangs; stiffness [N/m] and damping
    [N·s/m] along each of the sensor's `axes`."""

    mass: float
    centre: Array
    inertia: Array
    stiffness: float
    damping: float
    axes: str


def hang(payload: mujoco.MjsBody, hung: Hung) -> None:
    """Add it to the body behind the sensor."""
    child = payload.add_body(name="hung", mass=hung.mass)
    child.ipos = hung.centre
    i = hung.inertia
    child.fullinertia = [i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]]
    child.explicitinertial = True
    for axis in hung.axes:
        child.add_joint(
            name=f"slide {axis}", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=np.eye(3)["xyz".index(axis)],
            stiffness=hung.stiffness, damping=hung.damping,
        )  # fmt: skip


def slides(model: mujoco.MjModel, q: Array, rate_hz: float) -> tuple[Array, Array, Array]:
    """(T, S) position, speed and acceleration of the slides while the joints before them move as q (T, J) says.

    Semi-implicit Euler; the arm's motion is a spline through its samples. It begins at rest, sagged."""
    J, S = q.shape[1], model.nv - q.shape[1]
    data, time = mujoco.MjData(model), np.arange(len(q)) / rate_hz
    h = 1.0 / (rate_hz * SUBSTEPS)
    course = CubicSpline(time, q)
    arm = np.stack([course((time[:, None] + h * np.arange(SUBSTEPS)).ravel(), order) for order in range(3)], axis=1)
    M = np.zeros((model.nv, model.nv))

    def force(k: int, s: Array, v: Array) -> Array:
        data.qpos[:J], data.qpos[J:] = arm[k, 0], s
        data.qvel[:J], data.qvel[J:] = arm[k, 1], v
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        mujoco.mj_fullM(model, data, M)
        return np.asarray(data.qfrc_passive[J:] - data.qfrc_bias[J:] - M[J:, :J] @ arm[k, 2])

    s, v = np.zeros(S), np.zeros(S)
    stiffness = model.jnt_stiffness[J:]
    for _ in range(SETTLING):
        s = s + force(0, s, np.zeros(S)) / stiffness
    heavy = np.linalg.inv(M[J:, J:])  # of slides across each other: their body's mass, wherever they are
    out = np.empty((3, len(q), S))
    for k in range(len(arm)):
        a = heavy @ force(k, s, v)
        if k % SUBSTEPS == 0:
            out[:, k // SUBSTEPS] = s, v, a
        v = v + h * a
        s = s + h * v
    return out[0], out[1], out[2]
