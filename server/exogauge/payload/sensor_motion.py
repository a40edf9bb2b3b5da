"""How the sensor moves, in its own axes, and how well that is known: from joint angles, or from a logged pose."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
import pinocchio as pin
import scipy
from numpy.typing import NDArray

from exogauge.criteria.payload_dynamic import USUAL, Moving
from exogauge.loops.sensor_chain import end_motion
from exogauge.payload.imu import ImuFrame
from exogauge.payload.smoothing import Kind, Smoothed, at_times, smooth
from exogauge.robots.regressor import wrench_columns
from exogauge.robots.tree import RigidTree

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class SensorMotion:
    """T samples of {S}, all in {S}'s axes but rotation.

    time: (T,) [s]. rotation: (T, 3, 3) R_BS. acceleration: (T, 3) [m/s²] classical, of the origin, without gravity.
    alpha, omega: (T, 3) [rad/s², rad/s]. noise: (T, 9, K) root of the covariance of [a - g, α, ω] by the encoders.
    edge: samples at either end that are known worse. density: of each filtered channel. noisier: how many times the
    stated noise a channel shows at most, 1 where that holds. common: (T, 3, K) [m/s²] root of the covariance of errors
    of a - g that all samples share; None where there are none.
    """

    time: Array
    rotation: Array
    acceleration: Array
    alpha: Array
    omega: Array
    noise: Array
    edge: int = 0
    density: Array | None = None
    noisier: float = 1.0
    common: Array | None = None

    def regressor(self, gravity: Array) -> Array:
        """(T, 6, 10) A of [Payload] (5) for s = +1. gravity: (3,) [m/s²] in {B}."""
        A: Array = wrench_columns(self.proper_acceleration(gravity), self.alpha, self.omega)
        return A

    def proper_acceleration(self, gravity: Array) -> Array:
        """(T, 3) a - g in {S}."""
        b: Array = self.acceleration - np.einsum("tji,j->ti", self.rotation, gravity)
        return b

    def arrays(self, gravity: Array) -> tuple[Array, Array, Array, Array]:
        """a - g, α, ω (T, 3) and noise, as the loops take them."""
        b = self.proper_acceleration(gravity)
        alpha, omega, noise = (np.ascontiguousarray(each) for each in (self.alpha, self.omega, self.noise))
        return b, alpha, omega, noise

    def rows(self, which: slice | NDArray[np.bool_]) -> SensorMotion:
        """The same at the chosen samples."""
        names = ("time", "rotation", "acceleration", "alpha", "omega", "noise")
        common = None if self.common is None else self.common[which]
        return replace(self, edge=0, common=common, **{name: getattr(self, name)[which] for name in names})

    def inner(self) -> SensorMotion:
        """Without the edges."""
        return self.rows(slice(self.edge, len(self.time) - self.edge))


def joined(parts: Sequence[SensorMotion]) -> SensorMotion:
    """One after the other, of the same channels."""

    def whole(name: str) -> Array:
        return np.concatenate([getattr(part, name) for part in parts])

    return SensorMotion(
        whole("time"), whole("rotation"), whole("acceleration"), whole("alpha"), whole("omega"), whole("noise")
    )


@final
@dataclass(frozen=True)
class Chain:
    """What carries the sensor, from the base outward, as `loops.sensor_chain` takes it."""

    constants: tuple[Array, Array, Array, NDArray[np.bool_], NDArray[np.int64], Array, Array, Array, Array]

    @staticmethod
    def of(tree: RigidTree, frame: str) -> Chain:
        """frame: of the sensor; tree: on a fixed base."""
        body, pose = tree.frames[frame]
        path = list[int]()
        while body >= 0:
            path.insert(0, body)
            body = int(tree.parent[body])
        before, after = ([poses[k] for k in path] for poses in (tree.T_before, tree.T_after))
        return Chain((
            *_poses(before), tree.axis[path].reshape(-1, 3), tree.prismatic[path], tree.dof[path].astype(np.int64),
            *_poses(after), np.ascontiguousarray(pose.rotation), np.ascontiguousarray(pose.translation),
        ))  # fmt: skip

    def motion(self, time: Array, state: Array, roots: Array, gravity: Array) -> SensorMotion:
        """state: (T, J, 3) q, q̇, q̈. roots: (J, 3, 3) or (T, J, 3, 3) of the covariance of its errors."""
        T, joints = state.shape[:2]
        rotation, out, slopes = self.kinematics(np.moveaxis(state, 2, 0), gravity)
        noise = np.moveaxis(slopes @ roots, 1, 2).reshape(T, 9, 3 * joints)
        a = out[:, :3] + np.einsum("tji,j->ti", rotation, gravity)
        return SensorMotion(time, rotation, a, out[:, 3:6], out[:, 6:], noise)

    def kinematics(self, states: Array, gravity: Array) -> tuple[Array, Array, Array]:
        """states: (3, T, J) q, q̇, q̈. (T, 3, 3) R_BS, (T, 9) a - g, α, ω in {S}, and (T, J, 9, 3) slopes of these."""
        T, joints = states.shape[1:]
        rotation, out, slopes = np.empty((T, 3, 3)), np.empty((T, 9)), np.empty((T, joints, 9, 3))
        state = np.ascontiguousarray(np.moveaxis(states, 0, 2))
        end_motion(*self.constants, np.ascontiguousarray(gravity), state, rotation, out, slopes)
        return rotation, out, slopes

    def rotations(self, angles: Array) -> Array:
        """(T, 3, 3) R_BS at joint angles (T, J)."""
        return self.kinematics(np.stack([angles, 0 * angles, 0 * angles]), np.zeros(3))[0]


def from_joints(
    tree: RigidTree, frame: str, time: Array, angles: Array, std: float, gravity: Array,
    *, density: float | None = None, kind: Kind = "smoother", criteria: Moving = USUAL, at: Array | None = None,
) -> SensorMotion:  # fmt: skip
    """angles: (T, J) [rad] as logged, with errors of `std`. frame: of the sensor; tree: on a fixed base. at: (n,) times
    of another clock, for which it is told; those that lie where the smoother is not settled are left out."""
    smoothed = smooth(time, angles, std, density=density, kind=kind, criteria=criteria)
    if at is not None:
        at = _settled(at, time, smoothed.edge)
        time, smoothed = at, at_times(smoothed, time, at)
    motion = Chain.of(tree, frame).motion(time, smoothed.state, smoothed.noise, gravity)
    return replace(motion, edge=smoothed.edge, density=smoothed.density, noisier=float(smoothed.std.max()) / std)


def from_pose(
    time: Array, rotation: Array, position: Array, std_angle: float, std_position: float, gravity: Array,
    *, density: float | None = None, kind: Kind = "smoother", criteria: Moving = USUAL, at: Array | None = None,
    position_time: Array | None = None,
) -> SensorMotion:  # fmt: skip
    """rotation: (T, 3, 3) R_BS, position: (T, 3) [m] of the origin in {B}, as logged.

    The entries of the rotation are smoothed, and made a rotation again; ω and α are the skew parts of RᵀṘ and RᵀR̈.
    A density is that of the positions; that of rotations is always chosen. at: as in `from_joints`; position_time:
    (P,) of the positions, where they have a clock of their own, which then needs `at`.
    """
    turned = smooth(time, rotation.reshape(-1, 9), std_angle, kind=kind, criteria=criteria)
    clock = time if position_time is None else position_time
    moved = smooth(clock, position, std_position, density=density, kind=kind, criteria=criteria)
    if at is not None:
        at = _settled(_settled(at, time, turned.edge), clock, moved.edge)
        turned, moved, time = at_times(turned, time, at), at_times(moved, clock, at), at
    motion = pose_motion(
        time, turned.state, moved.state, turned.noise[int(np.argmax(turned.density))], moved.noise, gravity
    )
    edge = max(turned.edge, moved.edge)
    noisier = max(float(turned.std.max()) / std_angle, float(moved.std.max()) / std_position)
    return replace(motion, edge=edge, density=np.append(moved.density, turned.density.max()), noisier=noisier)


def _settled(at: Array, time: Array, edge: int) -> Array:
    """Those of some times at which a smoother of samples at `time` is settled."""
    return np.asarray(at[(at >= time[edge]) & (at <= time[len(time) - 1 - edge])])


def pose_motion(
    time: Array, turned: Array, moved: Array, root_turned: Array, roots_moved: Array, gravity: Array
) -> SensorMotion:
    """turned: (T, 9, 3) entries of R_BS, moved: (T, 3, 3) position, with two derivatives. root_turned: (3, 3) or
    (T, 3, 3) of an entry's errors; roots_moved: (3, 3, 3) or (T, 3, 3, 3)."""
    R, alpha, omega = _turning(turned)
    a = np.einsum("tji,tj->ti", R, moved[:, :, 2])
    noise = np.zeros((len(time), 9, 18))
    for k in range(3):
        noise[:, :3, 3 * k : 3 * k + 3] = R[:, k, :, None] * roots_moved[..., k, 2, :].reshape(-1, 1, 3)
        noise[:, 3 + k, 9 + 3 * k : 12 + 3 * k] = root_turned[..., 2, :]
        noise[:, 6 + k, 9 + 3 * k : 12 + 3 * k] = root_turned[..., 1, :]
    tipping = -np.einsum("tji,j->ti", R, gravity)
    for k, (x, y) in enumerate(((1, 2), (2, 0), (0, 1))):  # a turn about k: δ(a - g) = (a - g) x e_k δ
        noise[:, x, 9 + 3 * k : 12 + 3 * k] += tipping[:, y, None] * root_turned[..., 0, :]
        noise[:, y, 9 + 3 * k : 12 + 3 * k] -= tipping[:, x, None] * root_turned[..., 0, :]
    return SensorMotion(time, R, a, alpha, omega, noise)


def rotations(tree: RigidTree, frame: str, angles: Array) -> Array:
    """(K, 3, 3) R_BS at joint angles (K, J)."""
    return Chain.of(tree, frame).rotations(angles)


@final
@dataclass(frozen=True)
class Carried:
    """Rotations of the sensor and what an IMU on it reads, each by its own clock. turned: at time (T,) [s]; values,
    read: at read_time (N,) [s], as read and smoothed: what shakes is no noise, so only slopes are those of a smoother.
    noisier: as that of `SensorMotion`, of the rotations."""

    time: Array
    turned: Smoothed
    read_time: Array
    values: Array
    read: Smoothed
    noisier: float

    @staticmethod
    def of(
        time: Array, rotation: Array, std_angle: float, read_time: Array, read: Array, criteria: Moving = USUAL
    ) -> Carried:
        """rotation: (T, 3, 3) R_BS; read: (N, 3) [m/s²] in the IMU's axes. Nobody states its noise: it is what the
        innovations show."""
        shown = float(np.diff(read, 3, axis=0).std(axis=0).max()) / np.sqrt(20.0) if len(read) > 3 else 0.0
        least = 1e-9  # m/s²: of one without noise
        turned = smooth(time, rotation.reshape(-1, 9), std_angle, criteria=criteria)
        smoothed = smooth(read_time, read, max(shown, least), criteria=criteria)
        return Carried(time, turned, read_time, read, smoothed, float(turned.std.max()) / std_angle)

    def motion(self, at: Array, imu: ImuFrame, gravity: Array) -> tuple[SensorMotion, Array]:
        """At times (n,) of another clock where both are settled, and slopes (n, 3, 16) of a - g, as `imu` has them.
        gravity: (3,) [m/s²] in {B}."""
        at = _settled(_settled(at, self.time, 0), self.read_time - imu.lag_s, 0)
        turned, smoothed = at_times(self.turned, self.time, at), at_times(self.read, self.read_time, at + imu.lag_s)
        read = np.asarray(scipy.interpolate.CubicSpline(self.read_time, self.values)(at + imu.lag_s))
        R, alpha, omega = _turning(turned.state)
        root = self.turned.noise[int(np.argmax(self.turned.density))]
        noise = np.zeros((len(at), 9, 12))
        noise[:, :3, :3] = imu.matrix * self.read.std
        for k in range(3):
            noise[:, 3 + k, 3 + 3 * k : 6 + 3 * k], noise[:, 6 + k, 3 + 3 * k : 6 + 3 * k] = root[2], root[1]
        turn = _cross_matrix(omega)
        proper, slopes = imu.acceleration(
            read, smoothed.state[:, :, 1], _cross_matrix(alpha) + turn @ turn
        )  # fmt: skip
        a = proper + np.einsum("tji,j->ti", R, gravity)
        motion = SensorMotion(at, R, a, alpha, omega, noise, noisier=self.noisier, common=slopes @ imu.root)
        return motion, slopes


def _turning(entries: Array) -> tuple[Array, Array, Array]:
    R, dR, ddR = (entries[:, :, k].reshape(-1, 3, 3) for k in range(3))
    U, _, Vt = np.linalg.svd(R)
    R = U @ Vt
    return R, _skew_part(np.swapaxes(R, 1, 2) @ ddR), _skew_part(np.swapaxes(R, 1, 2) @ dR)


def _cross_matrix(v: Array) -> Array:
    """(T, 3, 3) of v (T, 3): [v]×."""
    return np.asarray(np.swapaxes(np.cross(v[:, None, :], np.eye(3)), 1, 2))


def _skew_part(M: Array) -> Array:
    return 0.5 * np.stack([M[:, 2, 1] - M[:, 1, 2], M[:, 0, 2] - M[:, 2, 0], M[:, 1, 0] - M[:, 0, 1]], axis=1)


def _poses(poses: Sequence[pin.SE3]) -> tuple[Array, Array]:
    """(n, 3, 3), (n, 3)."""
    return (
        np.array([pose.rotation for pose in poses]).reshape(-1, 3, 3),
        np.array([pose.translation for pose in poses]).reshape(-1, 3),
    )
