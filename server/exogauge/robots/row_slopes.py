"""How a sum of regressor rows changes with the motion: exact slopes, one sweep outward and one inward."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.robots.kinematics import Kinematics, Sweep, cross
from exogauge.robots.motion import Motion
from exogauge.robots.regressor import wrench_columns

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class WeightedRow:
    """axis: (T, 6) [linear; angular] motion about the base origin, base frame, along which the row asks for work.
    body: that the axis sits on, -1 for the base link. bodies: (n,) that it carries. phi: (n, T, 10) weights of their
    columns."""

    axis: Array
    body: int
    bodies: NDArray[np.intp]
    phi: Array


@final
@dataclass(frozen=True)
class MotionSlopes:
    """Of a number by a `Motion`, in its shapes."""

    q: Array
    dq: Array
    ddq: Array
    acc: Array
    gyro: Array
    gyro_dot: Array


def row_slopes(kinematics: Kinematics, motion: Motion, sweep: Sweep, rows: Sequence[WeightedRow]) -> MotionSlopes:
    """Slopes of Σ axisᵀ A_i phi_i over rows, bodies and samples, A_i the columns of body i about the base origin.

    A turn of joint k moves all that it carries rigidly, seen from which only what does not turn along is seen to
    change: V_k × S_k of a velocity, A_k × S_k + (V_k × S_k) × (V_i - V_k) of an acceleration, -S_k × S_j of an axis
    that sits before it. So all slopes are sums over subtrees.
    """
    tree, samples = kinematics.tree, motion.samples
    n, J = len(tree.bodies), len(tree.joints)
    R, S = np.moveaxis(sweep.R, 3, 1), np.moveaxis(sweep.S, 2, 1)
    p, w, dw, b = (np.moveaxis(each, 2, 1) for each in (sweep.p, sweep.omega, sweep.alpha, sweep.b))
    dq, ddq = (
        np.concatenate([x, np.zeros((samples, 1))], axis=1).T[tree.dof][..., None] for x in (motion.dq, motion.ddq)
    )
    V, A = np.empty((n + 1, samples, 6)), np.empty((n + 1, samples, 6))
    none = np.zeros((samples, 3))
    V[n], A[n] = np.concatenate([none, motion.gyro], axis=1), np.concatenate([motion.acc, motion.gyro_dot], axis=1)
    for i, up in enumerate(tree.parent):
        V[i] = V[up] + S[i] * dq[i]
        A[i] = A[up] + S[i] * ddq[i] + motion_cross(V[i], S[i] * dq[i])

    in_body = np.swapaxes(R, 2, 3)
    columns = wrench_columns(*((in_body @ each[..., None])[..., 0] for each in (b, dw, w)))
    M = np.zeros((n, samples, 6, 10))
    E, D = np.zeros((n, samples, 6)), np.zeros((n + 1, samples, 6))
    axes = np.stack([row.axis for row in rows], axis=1)
    carried = np.zeros_like(axes)  # (T, rows, 6) wrench of all that a row carries
    of_body: list[list[tuple[int, Array]]] = [[] for _ in range(n)]
    for r, row in enumerate(rows):
        for body, phi in zip(row.bodies.tolist(), row.phi, strict=True):
            of_body[body].append((r, phi))
    for i, found in enumerate(of_body):  # all rows of a body at once: (T, rows, …)
        if not found:
            continue
        at, phi = [r for r, _ in found], np.stack([each for _, each in found], axis=1)
        axis, place, turned = axes[:, at], p[i][:, None], (samples, -1, 3)
        seen = axis.copy()
        seen[..., :3] += cross(axis[..., 3:], place)
        M[i] = (seen.reshape(turned) @ R[i]).reshape(axis.shape).mT @ phi
        wrench = ((phi @ columns[i].mT).reshape(turned) @ R[i].mT).reshape(axis.shape)
        wrench[..., 3:] += cross(place, wrench[..., :3])
        E[i] = force_cross(axis, wrench).sum(axis=1)
        carried[:, at] += wrench
    for r, row in enumerate(rows):
        D[row.body] += force_cross(row.axis, carried[:, r])

    by_b, by_dw, by_w = (
        (R @ each[..., None])[..., 0] for each in _state_slopes(M, *((in_body @ x[..., None])[..., 0] for x in (dw, w)))
    )
    v = V[:n, :, :3] + cross(w, p)
    turning = cross(by_b, w)
    Q = np.concatenate([by_b, by_dw + cross(p, by_b)], axis=-1)
    P = np.concatenate([turning, by_w + cross(v, by_b) + cross(p, turning)], axis=-1)
    C = force_cross(V[:n], Q)
    parts = np.concatenate([P + C, Q, E - D[:n]], axis=-1)
    total = np.zeros((n + 1, samples, 18))
    for i in range(n - 1, -1, -1):
        total[i] += parts[i]
        total[tree.parent[i]] += total[i]
    P, Q, E = total[..., :6], total[..., 6:12], total[..., 12:]

    Z = motion_cross(V[:n], S)
    by_q = _dot(Z, P[:n] - force_cross(V[:n], Q[:n])) + _dot(motion_cross(A[:n], S), Q[:n]) - _dot(S, E[:n])
    by_dq = _dot(S, P[:n]) + 2.0 * _dot(Z, Q[:n])
    by_ddq = _dot(S, Q[:n])
    out = np.zeros((3, samples, J))
    moved = np.flatnonzero(tree.dof >= 0)
    for k, each in enumerate((by_q, by_dq, by_ddq)):
        out[k][:, tree.dof[moved]] = each[moved].T
    by_gyro = P[n] - force_cross(V[n], Q[n])
    return MotionSlopes(out[0], out[1], out[2], Q[n][:, :3].copy(), by_gyro[:, 3:].copy(), Q[n][:, 3:].copy())


def motion_cross(V: Array, S: Array) -> Array:
    """(..., 6) V × S."""
    v, w, s, u = V[..., :3], V[..., 3:], S[..., :3], S[..., 3:]
    return np.concatenate([cross(w, s) + cross(v, u), cross(w, u)], axis=-1)


def force_cross(V: Array, F: Array) -> Array:
    """(..., 6) V ×* F."""
    v, w, f, m = V[..., :3], V[..., 3:], F[..., :3], F[..., 3:]
    return np.concatenate([cross(w, f), cross(w, m) + cross(v, f)], axis=-1)


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(np.einsum("...k,...k->...", a, b))


def _state_slopes(M: Array, dw: Array, w: Array) -> tuple[Array, Array, Array]:
    """(..., 3) each of ⟨M, A⟩ by proper acceleration, angular acceleration and velocity; all in the body's axes.

    M: (..., 6, 10), A: `wrench_columns`.
    """
    mass, first, spin = M[..., :3, 0], M[..., 3:, 1:4], M[..., 3:, 4:]
    moved = M[..., :3, 1:4]
    W, L = _skew(w), _inertia(w)
    by_b = mass - _vee(first)
    by_dw = _vee(moved) + _by_inertia(spin)
    both = moved + np.swapaxes(moved, -1, -2)
    by_w = (both @ w[..., None])[..., 0] - np.trace(both, axis1=-2, axis2=-1)[..., None] * w
    by_w = by_w + _vee(spin @ np.swapaxes(L, -1, -2)) + _by_inertia(np.swapaxes(W, -1, -2) @ spin)
    return by_b, by_dw, by_w


def _vee(K: Array) -> Array:
    """(..., 3) x with ⟨K, skew(u)⟩ = x · u."""
    return np.stack([K[..., 2, 1] - K[..., 1, 2], K[..., 0, 2] - K[..., 2, 0], K[..., 1, 0] - K[..., 0, 1]], axis=-1)


def _skew(v: Array) -> Array:
    out = np.zeros((*v.shape, 3))
    out[..., 2, 1], out[..., 0, 2], out[..., 1, 0] = v[..., 0], v[..., 1], v[..., 2]
    return out - np.swapaxes(out, -1, -2)


PLACES = ((0, 0, 0), (0, 1, 1), (0, 3, 2), (1, 1, 0), (1, 2, 1), (1, 4, 2), (2, 3, 0), (2, 4, 1), (2, 5, 2))


def _inertia(x: Array) -> Array:
    """(..., 3, 6) L(x)."""
    out = np.zeros((*x.shape, 6))
    for row, column, component in PLACES:
        out[..., row, column] = x[..., component]
    return out


def _by_inertia(K: Array) -> Array:
    """(..., 3) x with ⟨K, L(u)⟩ = x · u."""
    out = np.zeros((*K.shape[:-2], 3))
    for row, column, component in PLACES:
        out[..., component] += K[..., row, column]
    return out
