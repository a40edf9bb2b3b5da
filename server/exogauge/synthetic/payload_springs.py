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
    course = CubicSpline(time, q)
    M = np.zeros((model.nv, model.nv))

    def acceleration(t: float, s: Array, v: Array) -> Array:
        data.qpos[:], data.qvel[:] = np.concatenate([course(t), s]), np.concatenate([course(t, 1), v])
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        mujoco.mj_fullM(model, data, M)
        force = data.qfrc_passive[J:] - data.qfrc_bias[J:] - M[J:, :J] @ course(t, 2)
        return np.asarray(np.linalg.solve(M[J:, J:], force))

    s, v = np.zeros(S), np.zeros(S)
    stiffness = model.jnt_stiffness[J:]
    for _ in range(SETTLING):
        held = acceleration(0.0, s, np.zeros(S))
        s = s + np.asarray(M[J:, J:] @ held) / stiffness
    out = np.empty((3, len(q), S))
    h = 1.0 / (rate_hz * SUBSTEPS)
    for k, t in enumerate(time):
        out[0, k], out[1, k], out[2, k] = s, v, acceleration(t, s, v)
        for n in range(SUBSTEPS):
            v = v + h * acceleration(t + n * h, s, v)
            s = s + h * v
    return out[0], out[1], out[2]
