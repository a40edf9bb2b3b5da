"""How the sensor moves, in its own axes, and how well that is known: from joint angles, or from a logged pose."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.payload.smoothing import Kind, Smoothed, smooth
from exogauge.robots.kinematics import Kinematics
from exogauge.robots.motion import Motion
from exogauge.robots.regressor import wrench_columns
from exogauge.robots.tree import RigidTree

Array = NDArray[np.float64]

STEP = 1e-6  # of differences: kinematics are quadratic at most in velocities and accelerations


@final
@dataclass(frozen=True)
class SensorMotion:
    """T samples of {S}, all in {S}'s axes but rotation.

    time: (T,) [s]. rotation: (T, 3, 3) R_BS. acceleration: (T, 3) [m/s²] classical, of the origin, without gravity.
    alpha, omega: (T, 3) [rad/s², rad/s]. noise: (T, 9, K) root of the covariance of [a - g, α, ω] by the encoders.
    edge: samples at either end that are known worse. density: of each filtered channel.
    """

    time: Array
    rotation: Array
    acceleration: Array
    alpha: Array
    omega: Array
    noise: Array
    edge: int = 0
    density: Array | None = None

    def regressor(self, gravity: Array) -> Array:
        """(T, 6, 10) A of [Payload] (5) for s = +1. gravity: (3,) [m/s²] in {B}."""
        A: Array = wrench_columns(self.proper_acceleration(gravity), self.alpha, self.omega)
        return A

    def proper_acceleration(self, gravity: Array) -> Array:
        """(T, 3) a - g in {S}."""
        b: Array = self.acceleration - np.einsum("tji,j->ti", self.rotation, gravity)
        return b

    def rows(self, which: slice | NDArray[np.bool_]) -> SensorMotion:
        """The same at the chosen samples."""
        names = ("time", "rotation", "acceleration", "alpha", "omega", "noise")
        return replace(self, edge=0, **{name: getattr(self, name)[which] for name in names})

    def inner(self) -> SensorMotion:
        """Without the edges."""
        return self.rows(slice(self.edge, len(self.time) - self.edge))


def from_joints(
    tree: RigidTree, frame: str, time: Array, angles: Array, std: float, gravity: Array,
    *, density: float | None = None, kind: Kind = "smoother",
) -> SensorMotion:  # fmt: skip
    """angles: (T, J) [rad] as logged, with errors of `std`. frame: of the sensor; tree: on a fixed base."""
    smoothed = smooth(time, angles, std, density=density, kind=kind)
    kinematics = Kinematics(tree)

    def at(state: Array) -> tuple[Array, Array, Array, Array]:
        return _frame_motion(kinematics, frame, state)

    def stacked(R: Array, b: Array, dw: Array, w: Array) -> Array:
        return np.concatenate([b - np.einsum("tji,j->ti", R, gravity), dw, w], axis=1)

    rotation, a, alpha, omega = at(smoothed.state)
    here = stacked(rotation, a, alpha, omega)
    joints = angles.shape[1]
    noise = np.empty((len(time), 9, 3 * joints))
    for j in range(joints):
        slopes = np.empty((len(time), 9, 3))
        for order in range(3):
            h = STEP if order == 0 else 1.0
            ends = [here] if order == 2 else []  # linear in q̈
            for side in (-1.0, 1.0)[len(ends) :]:
                state = smoothed.state.copy()
                state[:, j, order] += side * h
                ends.append(stacked(*at(state)))
            slopes[:, :, order] = (ends[1] - ends[0]) / (h if order == 2 else 2.0 * h)
        noise[:, :, 3 * j : 3 * j + 3] = slopes @ smoothed.noise[j]
    return SensorMotion(time, rotation, a, alpha, omega, noise, smoothed.edge, smoothed.density)


def from_pose(
    time: Array, rotation: Array, position: Array, std_angle: float, std_position: float, gravity: Array,
    *, density: float | None = None, kind: Kind = "smoother",
) -> SensorMotion:  # fmt: skip
    """rotation: (T, 3, 3) R_BS, position: (T, 3) [m] of the origin in {B}, as logged.

    The entries of the rotation are smoothed, and made a rotation again; ω and α are the skew parts of RᵀṘ and RᵀR̈.
    A density is that of the positions; that of rotations is always chosen.
    """
    turned = smooth(time, rotation.reshape(-1, 9), std_angle, kind=kind)
    moved = smooth(time, position, std_position, density=density, kind=kind)
    R, alpha, omega = _turning(turned)
    a = np.einsum("tji,tj->ti", R, moved.state[:, :, 2])
    noise = np.zeros((len(time), 9, 18))
    mean = turned.noise[int(np.argmax(turned.density))]
    for k in range(3):
        noise[:, :3, 3 * k : 3 * k + 3] = R[:, k, :, None] * moved.noise[k][2]
        noise[:, 3 + k, 9 + 3 * k : 12 + 3 * k] = mean[2]
        noise[:, 6 + k, 9 + 3 * k : 12 + 3 * k] = mean[1]
    tipping = -np.einsum("tji,j->ti", R, gravity)
    for k, (x, y) in enumerate(((1, 2), (2, 0), (0, 1))):  # a turn about k: δ(a - g) = (a - g) x e_k δ
        noise[:, x, 9 + 3 * k : 12 + 3 * k] += tipping[:, y, None] * mean[0]
        noise[:, y, 9 + 3 * k : 12 + 3 * k] -= tipping[:, x, None] * mean[0]
    edge = max(turned.edge, moved.edge)
    return SensorMotion(time, R, a, alpha, omega, noise, edge, np.append(moved.density, turned.density.max()))


def rotations(tree: RigidTree, frame: str, angles: Array) -> Array:
    """(K, 3, 3) R_BS at joint angles (K, J)."""
    return _frame_motion(Kinematics(tree), frame, np.stack([angles, 0 * angles, 0 * angles], axis=2))[0]


def turning(time: Array, rotation: Array, std_angle: float) -> tuple[Array, Array, Array]:
    """R_BS (T, 3, 3) smoothed, α and ω (T, 3) in {S}, from logged rotations (T, 3, 3)."""
    return _turning(smooth(time, rotation.reshape(-1, 9), std_angle))


def _turning(entries: Smoothed) -> tuple[Array, Array, Array]:
    R, dR, ddR = (entries.state[:, :, k].reshape(-1, 3, 3) for k in range(3))
    U, _, Vt = np.linalg.svd(R)
    R = U @ Vt
    return R, _skew_part(np.swapaxes(R, 1, 2) @ ddR), _skew_part(np.swapaxes(R, 1, 2) @ dR)


def _skew_part(M: Array) -> Array:
    return 0.5 * np.stack([M[:, 2, 1] - M[:, 1, 2], M[:, 0, 2] - M[:, 2, 0], M[:, 1, 0] - M[:, 0, 1]], axis=1)


def _frame_motion(kinematics: Kinematics, frame: str, state: Array) -> tuple[Array, Array, Array, Array]:
    """R_BS, and in {S} classical acceleration of its origin, angular acceleration, angular velocity. state: (T, J, 3).

    The sweep's base does not accelerate: what it calls proper is then the classical acceleration itself.
    """
    samples = len(state)
    still = np.zeros((samples, 3))
    sweep = kinematics.sweep(Motion(state[:, :, 0], state[:, :, 1], state[:, :, 2], still, still, still))
    body, pose = kinematics.tree.frames[frame]
    if body < 0:
        return np.tile(pose.rotation, (samples, 1, 1)), still, still, still
    R_body, B = np.moveaxis(sweep.R[body], 2, 0), np.moveaxis(sweep.B[body], 2, 0)
    a = sweep.b[body].T + np.einsum("tij,tjk,k->ti", B, R_body, pose.translation)
    R = R_body @ pose.rotation
    in_sensor = [np.einsum("tji,tj->ti", R, each) for each in (a, sweep.alpha[body].T, sweep.omega[body].T)]
    return R, in_sensor[0], in_sensor[1], in_sensor[2]
