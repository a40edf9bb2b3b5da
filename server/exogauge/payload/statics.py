"""The static stage: what holds in several postures say of mass, centre of mass, the sensor's zero and the base.

All wrenches in the sensor's axes {S}, force then moment about its origin. {B} is the robot's base, {W} the world.
s = +1 where the sensor reads what it does to the payload, -1 where it reads what the payload does to it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, final

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from exogauge.criteria.payload_static import USUAL, Standing
from exogauge.errors import NotIdentifiable
from exogauge.payload.total_least_squares import only_output, solve, triangle

Array = NDArray[np.float64]
Method = Literal["ls", "tls", "gtls"]
Misread = Literal["transposed", "world_axes", "sensor_axes", "unexplained"]


@final
@dataclass(frozen=True)
class Holds:
    """K postures in which nothing moved.

    rotation: (K, 3, 3) R_BS. wrench: (K, 6) [N, N·m] means. std: (6,) [N, N·m] of a mean's error, from the sensor's
    noise. tilt_noise: [rad] of the rotation, for GTLS. spans: (K, 2) [s] from, to, in the log's time. unrest: (6,) rms
    of half of what the two halves of a posture differ in: about `std`, more where something swings on. noise: (6,) std
    of a sample within a posture. stamps: (K,) [s] of their middles, by the clock of the logs.
    """

    rotation: Array
    wrench: Array
    std: Array
    tilt_noise: float = 0.0
    spans: Array | None = None
    unrest: Array | None = None
    noise: Array | None = None
    stamps: Array | None = None

    def __len__(self) -> int:
        return len(self.wrench)

    def but(self, k: int) -> Holds:
        """Without posture k."""
        return self.only(np.arange(len(self)) != k)

    def only(self, keep: NDArray[np.bool_]) -> Holds:
        spans, stamps = (None if each is None else each[keep] for each in (self.spans, self.stamps))
        return replace(self, rotation=self.rotation[keep], wrench=self.wrench[keep], spans=spans, stamps=stamps)

    def alike(self, gravity: Array, criteria: Standing = USUAL) -> bool:
        """Whether gravity, (3,) in {B}, pulls in the same direction of the sensor in all of them."""
        down = np.einsum("kji,j->ki", self.rotation, gravity / np.linalg.norm(gravity))
        return bool(np.arccos(np.clip(down @ down[0], -1.0, 1.0)).max() < np.radians(criteria.alike_deg))


@final
@dataclass(frozen=True)
class StaticSolution:
    """mass [kg]; centre (3,) [m]; zero (6,) [N, N·m]; gravity (3,) [m/s²] in {B}; tilt (2,) [rad] U, V.

    covariance: (12, 12) of [mass, centre, zero, U, V], from what the postures leave, not below the stated noise.
    residual: (K, 6). sign: s. inclined: whether U, V were fitted. condition: of the force and the moment part.
    """

    mass: float
    centre: Array
    zero: Array
    gravity: Array
    tilt: Array
    covariance: Array
    residual: Array
    sign: int
    inclined: bool
    condition: tuple[float, float]

    @property
    def std(self) -> Array:
        """(12,) of [mass, centre, zero, U, V]."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def moments(self) -> tuple[Array, Array]:
        """(10,) [m, m c, zero], and (12, 12) covariance of it and of the turn of gravity about two axes across it: the
        prior of the dynamic stage."""
        J = np.diag([1.0] * 10 + [-1.0] * 2)  # gravity turns the other way than the base
        J[1:4, 0], J[1:4, 1:4] = self.centre, self.mass * np.eye(3)
        value = np.concatenate([[self.mass], self.mass * self.centre, self.zero])
        return value, J @ self.covariance @ J.T

    def doubted(self, doubt: Array) -> StaticSolution:
        """With more doubt: (18, 18) of [m, m c, I, F_0, turn of gravity about x, y where it is upright]."""
        J = np.zeros((12, 18))
        J[0, 0], J[1:4, 0], J[1:4, 1:4] = 1.0, -self.centre / self.mass, np.eye(3) / self.mass
        J[4:10, 10:16], J[10:, 16:] = np.eye(6), -np.eye(2)  # gravity turns the other way than the base
        return replace(self, covariance=self.covariance + J @ doubt @ J.T)

    def predict(self, rotation: Array) -> Array:
        """(K, 6) wrench in postures R_BS (K, 3, 3)."""
        weight = -self.sign * self.mass * np.einsum("kji,j->ki", rotation, self.gravity)
        return np.concatenate([weight, np.cross(self.centre, weight)], axis=1) + self.zero


def force_columns(rotation: Array) -> Array:
    """(3K, 6) [R_BSᵀ 1] of [κ, f_0].

    Implements [Payload] (13); (14) in general: κ = -s m g_B.
    """
    return np.concatenate([np.swapaxes(rotation, 1, 2), np.tile(np.eye(3), (len(rotation), 1, 1))], axis=2).reshape(
        -1, 6
    )


def moment_columns(force: Array) -> Array:
    """(3K, 6) [-[f]× 1] of [c, ι]: τ = c x f + ι. force: (K, 3) as read.

    Implements [Payload] (15).
    """
    cross = np.zeros((len(force), 3, 6))
    for row, f in zip(cross, force, strict=True):
        row[:, :3] = -pin.skew(f)
    cross[:, :, 3:] = np.eye(3)
    return cross.reshape(-1, 6)


def gravity_of(U: float, V: float) -> Array:
    """(3,) unit gravity in {B} where {B} is {W} turned by U about x, then by V about y.

    Implements [Payload] (6), (8), (9).
    """
    return np.array([np.cos(U) * np.sin(V), -np.sin(U), -np.cos(U) * np.cos(V)])


def inclination(kappa: Array, sign: int) -> Array:
    """(2,) U, V [rad] from κ (3,) = -s m g_B.

    Implements [Payload] (19). Differs from print: with the unit gravity d = -s κ/|κ|, U = atan2(-d_y, hypot(d_x, d_z)),
    V = atan2(d_x, -d_z); as printed both signs are wrong for the κ of (14).
    """
    d = -sign * kappa / np.linalg.norm(kappa)
    return np.array([np.arctan2(-d[1], np.hypot(d[0], d[2])), np.arctan2(d[0], -d[2])])


def torque_zero(iota: Array, centre: Array, force_zero: Array) -> Array:
    """(3,) τ_0 = ι + c x f_0.

    Implements [Payload] (16), (20); the printed crosses are products of numbers.
    """
    return np.asarray(iota + np.cross(centre, force_zero))


def told_sign(holds: Holds, gravity: Array, criteria: Standing = USUAL) -> int:
    """s, from the side to which κ points; right while the base is inclined by less than 90°."""
    _require_rank(holds, True, criteria)
    kappa = np.linalg.lstsq(force_columns(holds.rotation), holds.wrench[:, :3].ravel())[0][:3]
    return -1 if kappa @ gravity > 0 else 1


def static_stage(
    holds: Holds, gravity: Array, sign: int, *, inclined: bool = True, method: Method = "ls",
    criteria: Standing = USUAL,
) -> StaticSolution:  # fmt: skip
    """gravity: (3,) [m/s²] in {B} as stated; its direction is fitted where `inclined`.

    Implements [Payload] (11)-(20), (24), (26). U, V are told against the stated direction.
    Raises NotIdentifiable where the postures do not decide everything.
    """
    _require_rank(holds, inclined, criteria)
    K, g = len(holds), float(np.linalg.norm(gravity))
    f, tau = holds.wrench[:, :3], holds.wrench[:, 3:]
    A = force_columns(holds.rotation)
    if not inclined:
        A = np.column_stack([A[:, :3] @ (-sign * gravity), A[:, 3:]])
    x, covariance_x, left_f = _fit(A, f.ravel(), holds.std[:3], method, _force_noise(holds, A))
    kappa, f_0 = (x[:3], x[3:]) if inclined else (-sign * x[0] * gravity, x[1:])
    B = moment_columns(f)
    y, _, left_t = _fit(B, tau.ravel(), holds.std[3:], method, _moment_noise(holds, B))
    least_squares = _fit(B, tau.ravel(), moment_noise(holds.std, y[:3]), "ls", np.zeros((6, 6)))
    covariance_y = least_squares[1]
    if method == "ls":
        y, _, left_t = least_squares
    c, iota = y[:3], y[3:]

    mass = float(np.linalg.norm(kappa)) / g
    d = -sign * kappa / np.linalg.norm(kappa)
    stand = upright(gravity)
    tilt = inclination(stand @ kappa, sign) if inclined else np.zeros(2)
    zero = np.concatenate([f_0, torque_zero(iota, c, f_0)])
    J = np.zeros((12, len(x) + 6))  # of [mass, centre, zero, U, V] by [x, c, ι]
    first = len(x) - 3
    if inclined:
        J[0, :3] = kappa / (np.linalg.norm(kappa) * g)
        h = 1e-6 * float(np.linalg.norm(kappa))
        for k, e in enumerate(np.eye(3)):
            J[10:, k] = inclination(stand @ (kappa + h * e), sign) - inclination(stand @ (kappa - h * e), sign)
        J[10:, :3] /= 2 * h
    else:
        J[0, 0] = 1.0
    J[1:4, first + 3 : first + 6] = np.eye(3)
    J[4:7, first : first + 3] = np.eye(3)
    J[7:10, first : first + 3] = pin.skew(c)
    J[7:10, first + 3 : first + 6] = -pin.skew(f_0)
    J[7:10, first + 6 :] = np.eye(3)
    inner = np.zeros((len(x) + 6, len(x) + 6))
    inner[: len(x), : len(x)], inner[len(x) :, len(x) :] = covariance_x, covariance_y
    residual = np.concatenate([left_f.reshape(K, 3), left_t.reshape(K, 3)], axis=1)
    conditions = (_condition(A), _condition(B))
    return StaticSolution(
        mass, c, zero, g * d, tilt, J @ inner @ J.T, residual, sign, inclined, conditions
    )  # fmt: skip


@final
@dataclass(frozen=True)
class LeftOut:
    """Root mean square of the errors in a posture that was not fitted: force [N], moment [N·m]."""

    force: float
    moment: float


def leave_one_out(holds: Holds, gravity: Array, sign: int, *, inclined: bool, criteria: Standing = USUAL) -> LeftOut:
    """Each posture predicted from the others. Raises NotIdentifiable where one of them cannot be missed."""
    errors = left_out_errors(holds, gravity, sign, inclined=inclined, criteria=criteria)
    return LeftOut(float(np.sqrt(np.mean(errors[:, :3] ** 2))), float(np.sqrt(np.mean(errors[:, 3:] ** 2))))


def left_out_errors(holds: Holds, gravity: Array, sign: int, *, inclined: bool, criteria: Standing = USUAL) -> Array:
    """(K, 6) what a posture reads beyond what the others say. Raises NotIdentifiable."""

    def predicted(k: int) -> Array:
        others = static_stage(holds.but(k), gravity, sign, inclined=inclined, criteria=criteria)
        return np.asarray(others.predict(holds.rotation[[k]])[0])

    return np.array([holds.wrench[k] - predicted(k) for k in range(len(holds))])


def touched_postures(holds: Holds, gravity: Array, sign: int, criteria: Standing = USUAL) -> dict[int, Array]:
    """By number the (6,) that a posture reads beyond what the others say, where they agree and it does not: something
    touched. None where many differ."""
    keep, found = np.ones(len(holds), dtype=bool), dict[int, Array]()
    while True:
        try:
            errors = left_out_errors(holds.only(keep), gravity, sign, inclined=True, criteria=criteria)
            sizes = np.linalg.norm(errors / holds.std, axis=1)
            worst = int(np.argmax(sizes))
            without = holds.only(keep).but(worst)
            others = left_out_errors(without, gravity, sign, inclined=True, criteria=criteria) / without.std
        except NotIdentifiable:
            return found
        rest = float(np.sqrt(np.mean(np.sum(others**2, axis=1))))
        if sizes[worst] < criteria.outlier * max(rest, np.sqrt(6.0)):
            return found
        number = int(np.flatnonzero(keep)[worst])
        keep[number], found[number] = False, errors[worst]
        if len(found) > criteria.outliers * len(holds):
            return {}


def further_posture(holds: Holds, solution: StaticSolution, criteria: Standing = USUAL) -> tuple[Array, Array]:
    """(3,) direction of gravity in {S} of the posture that would tell most, and (12,) the std with it.

    Chosen from 8 x 5 x 8 Euler angles, by the determinant of the information.
    """
    rms = np.sqrt(np.mean(solution.residual**2, axis=0))
    noise = np.maximum(np.repeat([rms[:3].mean(), rms[3:].mean()], 3), holds.std)
    angles = np.linspace(-np.pi, np.pi, 8, endpoint=False)
    candidates = np.array([pin.rpy.rpyToMatrix(x, y, z) for x in angles for y in angles[2:7] for z in angles])
    wrenches = solution.predict(candidates)

    def weighted(rotation: Array, wrench: Array) -> tuple[Array, Array]:
        rows = np.tile(noise.reshape(2, 3), len(rotation))[:, :, None]
        return force_columns(rotation) / rows[0], moment_columns(wrench[:, :3]) / rows[1]

    def information(rotation: Array, wrench: Array) -> float:
        parts = weighted(rotation, wrench)
        return sum(float(np.linalg.slogdet(before + A.T @ A)[1]) for before, A in zip(held, parts, strict=True))

    held = [A.T @ A for A in weighted(holds.rotation, holds.wrench)]
    gains = [information(R[None], w[None]) for R, w in zip(candidates, wrenches, strict=True)]
    k = int(np.argmax(gains))
    rotation = np.concatenate([holds.rotation, candidates[[k]]])
    exact = Holds(rotation, solution.predict(rotation), noise)
    now, then = (
        static_stage(each, solution.gravity, solution.sign, inclined=solution.inclined, criteria=criteria).std
        for each in (exact.but(len(holds)), exact)
    )
    direction = candidates[k].T @ solution.gravity / np.linalg.norm(solution.gravity)
    return direction, solution.std * then / np.where(now > 0, now, 1.0)


def misread_rotation(holds: Holds, gravity: Array, criteria: Standing = USUAL) -> Misread | None:
    """What the postures fit clearly better than what is stated: R_SB for R_BS, wrenches that are in the base's axes,
    wrenches that are in the sensor's already. `unexplained` where none of these does, and what is stated neither.

    Forces fit the first two alike, with κ and the zero exchanged: the one whose κ points along gravity is told.
    """
    if _rank(holds.rotation, criteria.rank) < 6:
        return None

    def fitted(rotation: Array, force: Array) -> tuple[float, float]:
        A = force_columns(rotation)
        x = np.linalg.lstsq(A, force.ravel())[0]
        along = abs(float(x[:3] @ gravity)) / float(np.linalg.norm(x[:3]) * np.linalg.norm(gravity))
        return float(np.sqrt(np.mean((A @ x - force.ravel()) ** 2))), along

    f, R = holds.wrench[:, :3], holds.rotation
    as_stated = fitted(R, f)[0]
    weight = float(np.abs(f - f.mean(axis=0)).max())
    if as_stated < max(criteria.clearly * float(holds.std[:3].max()), criteria.unexplained * weight):
        return None
    others: dict[Misread, tuple[float, float]] = {
        "transposed": fitted(np.swapaxes(R, 1, 2), f),
        "world_axes": fitted(R, np.einsum("kji,kj->ki", R, f)),
        "sensor_axes": fitted(R, np.einsum("kij,kj->ki", R, f)),
    }
    fitting = [name for name, (left, _) in others.items() if criteria.clearly * left < as_stated]
    if fitting:
        return max(fitting, key=lambda name: others[name][1])
    return "unexplained" if as_stated > criteria.unexplained_clearly * weight else None


def forces_among_moments(holds: Holds, criteria: Standing = USUAL) -> bool:
    """Whether a weight explains the moments as forces, and clearly better than the forces."""
    shares = []
    for part in (holds.wrench[:, 3:], holds.wrench[:, :3]):
        A, b = force_columns(holds.rotation), part.ravel()
        left = A @ np.linalg.lstsq(A, b)[0] - b
        shares.append(float(np.sqrt(np.mean(left**2)) / max(float(np.ptp(part, axis=0).max()), 1e-300)))
    return shares[0] < criteria.unexplained and criteria.clearly * shares[0] < shares[1]


def _fit(A: Array, b: Array, std: Array, method: Method, noise: Array) -> tuple[Array, Array, Array]:
    """Parameters, their covariance and the residual. std: (3,) of the axes, which take turns in the rows. noise: (n, n)
    summed covariance of A's rows."""
    Z = np.column_stack([A, b]) / np.resize(std, len(b))[:, None]
    P = only_output(Z.shape[1], len(b))
    if method == "tls":
        P = np.eye(len(P))
    elif method == "gtls":
        P[:-1, :-1] = noise * np.mean(std**-2.0)
    found = solve(triangle(Z), P)
    left = Z @ np.append(-found.value, 1.0)
    spread = max(float(left @ left) / max(len(b) - A.shape[1], 1), 1.0)
    return found.value, spread * np.linalg.inv(Z[:, :-1].T @ Z[:, :-1]), b - A @ found.value


def moment_noise(std: Array, centre: Array) -> Array:
    """(3,) [N·m] by which τ - c x f errs, as both are read. std: (6,) of the channels."""
    return np.asarray(np.hypot(std[3:], np.sqrt(pin.skew(centre) ** 2 @ std[:3] ** 2)))


def _force_noise(holds: Holds, A: Array) -> Array:
    """R_BSᵀ errs by turning: entries of its rows, two directions of each, by the tilt's noise."""
    P = np.zeros((A.shape[1], A.shape[1]))
    k = A.shape[1] - 3
    size = 1.0 if k == 3 else float(np.sum(A[:3, 0] ** 2))
    P[:k, :k] = 2.0 * len(holds) * holds.tilt_noise**2 * size * np.eye(k)
    return P


def _moment_noise(holds: Holds, B: Array) -> Array:
    P = np.zeros((6, 6))
    P[:3, :3] = 2.0 * len(holds) * float(np.mean(holds.std[:3] ** 2)) * np.eye(3)
    return P


def upright(gravity: Array) -> Array:
    """(3, 3) the least turn that takes gravity, (3,) in {B}, to -z."""
    return np.asarray(
        pin.Quaternion.FromTwoVectors(gravity / np.linalg.norm(gravity), -np.eye(3)[2]).toRotationMatrix()
    )


def _rank(rotation: Array, least: float) -> int:
    A = force_columns(rotation)
    value = np.linalg.svd(A / np.linalg.norm(A, axis=0), compute_uv=False)
    return int((value > least * value[0]).sum())


def _require_rank(holds: Holds, inclined: bool, criteria: Standing) -> None:
    """1, 2, 3 postures that differ in gravity and about it leave 3, 5, 6 of the six numbers of either part."""
    rank, wanted = _rank(holds.rotation, criteria.rank), 6
    B = moment_columns(holds.wrench[:, :3])
    weights = np.linalg.svd(holds.wrench[:, :3] - holds.wrench[:, :3].mean(axis=0), compute_uv=False)
    moment_rank = 3 + min(3, int((weights > criteria.rank * max(float(np.abs(B).max()), 1e-9)).sum()) + 1) * (
        len(holds) > 1
    )
    if (rank < wanted and inclined) or moment_rank < 6:
        raise NotIdentifiable(
            f"{len(holds)} postures decide {rank} of 6 numbers of the force and {moment_rank} of 6 of the moment; hold "
            "still in at least three in which gravity has other directions in the sensor's axes",
            ("mass", "centre", "zero", "inclination"),
        )


def _condition(A: Array) -> float:
    """Of the matrix with columns of equal length."""
    value = np.linalg.svd(A / np.linalg.norm(A, axis=0), compute_uv=False)
    return float(value[0] / value[-1])
