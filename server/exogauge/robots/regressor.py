"""Equations of motion, linear in the inertial parameters: base-link wrench and joint torques, batched over time.

The reference: dense, in body frames. `row_blocks` computes the same by another route and only where it is not zero.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.robots.kinematics import BodyStates, forward, joint_motions
from exogauge.robots.motion import Motion
from exogauge.robots.tree import RigidTree

Array = NDArray[np.float64]


def regressor(tree: RigidTree, motion: Motion) -> Array:
    """(T, 6+J, 10N) Y = [Y_o; Y_j]: Y φ = [F_o; τ_j + F_j]; without the six base rows for a fixed base: (T, J, 10N).

    Rows 0..5: force then moment about the base link's origin, in its frame; then joint torque [N·m] or force [N].
    Columns: body by body, as `RigidTree.phi`.

    Implements [Evaluator] (10), (11), (13).
    """
    wrench, _ = wrench_regressor(tree, motion)
    S = joint_motions(tree, motion.q)
    samples, n = wrench.shape[:2]
    start = 6 if tree.floating else 0
    Y = np.zeros((samples, start + len(tree.joints), n, 10))
    if tree.floating:
        Y[:, :6] = np.swapaxes(wrench, 1, 2)
    carried = tree.subtree
    for i in np.flatnonzero(tree.dof >= 0):
        Y[:, start + tree.dof[i], carried[i]] = np.einsum("ta,tnak->tnk", S[:, i], wrench[:, carried[i]])
    return Y.reshape(samples, -1, 10 * n)


def wrench_regressor(tree: RigidTree, motion: Motion) -> tuple[Array, BodyStates]:
    """(T, N, 6, 10) wrench that moves each body, about the base origin in the base frame, per inertial parameter."""
    states = forward(tree, motion)
    return to_base(states, body_regressor(states)), states


def inverse_dynamics(tree: RigidTree, motion: Motion, phi: Array) -> Array:
    """(T, 6+J) or, fixed base, (T, J): Y φ without building Y. phi: (N, 10)."""
    wrench, _ = moving_wrenches(tree, motion, phi)
    return _project(tree, motion.q, wrench)


def moving_wrenches(tree: RigidTree, motion: Motion, phi: Array) -> tuple[Array, BodyStates]:
    """(T, N, 6) force and moment that move each body, about the base origin in the base frame. phi: (N, 10)."""
    states = forward(tree, motion)
    w, dw, b = states.omega, states.alpha, states.proper_acceleration
    m, h, I = phi[:, 0], phi[:, 1:4], inertia_matrices(phi)  # noqa: E741 (the paper's letter)
    I_w = np.einsum("nij,tnj->tni", I, w)
    force = m[:, None] * b + np.cross(dw, h) + np.cross(w, np.cross(w, h))
    moment = np.cross(h, b) + np.einsum("nij,tnj->tni", I, dw) + np.cross(w, I_w)
    return to_base(states, np.concatenate([force, moment], axis=2)[..., None])[..., 0], states


def contact_effect(tree: RigidTree, q: Array, frame: str, wrench: Array) -> Array:
    """(T, 6+J) or, fixed base, (T, J): [F_o; F_j] = K^T F of a wrench on the robot.

    wrench: (T, 6) force then moment of the world on the robot, in the frame's coordinates, about its origin.
    frame: a name in `tree.frames`.

    Implements [Evaluator] (10), the terms K^T F.
    """
    body, pose = tree.frames[frame]
    n = len(tree.bodies)
    in_base = np.zeros((len(q), n, 6))
    local = np.asarray(wrench) @ pose.toActionMatrixInverse()  # act on a wrench = A^-T, so rows times A^-1
    if body < 0:
        return np.zeros((len(q), len(tree.joints)))
    still = np.zeros((len(q), 3))
    states = forward(tree, Motion(q, np.zeros_like(q), np.zeros_like(q), still, still, still))
    in_base[:, body] = _shift(states.rotation[:, body], states.position[:, body], local[..., None])[..., 0]
    return _project(tree, q, in_base)


def body_regressor(states: BodyStates) -> Array:
    """(T, N, 6, 10) wrench that moves one body, about its origin in its frame, per inertial parameter.

    As `pinocchio.bodyRegressor`; [Payload] (5) up to the order of its columns.
    """
    return wrench_columns(states.proper_acceleration, states.alpha, states.omega)


def wrench_columns(proper_acceleration: Array, alpha: Array, omega: Array) -> Array:
    """(..., 6, 10) wrench that moves a body, about the origin of its frame in its axes, per inertial parameter.

    All (..., 3), of the frame, in its axes: proper acceleration a - g of its origin (a classical) [m/s²], angular
    acceleration [rad/s²] and velocity [rad/s].

    Implements [Payload] (2)-(5) for s = +1. Differs from print: a - g for a + g; entry (1, 4) is w_x w_z + alpha_y;
    ten columns, in the order of `RigidTree.phi`.
    """
    b, dw, w = proper_acceleration, alpha, omega
    W = _skew(w)
    A = np.zeros((*w.shape[:-1], 6, 10))
    A[..., :3, 0] = b
    A[..., :3, 1:4] = _skew(dw) + W @ W
    A[..., 3:, 1:4] = -_skew(b)
    A[..., 3:, 4:] = _inertia_columns(dw) + W @ _inertia_columns(w)
    return A


def inertia_matrices(phi: Array) -> Array:
    """(N, 3, 3) inertia about each body's origin, from (N, 10) parameters."""
    return phi[:, [4, 5, 7, 5, 6, 8, 7, 8, 9]].reshape(-1, 3, 3)


def _project(tree: RigidTree, q: Array, wrench: Array) -> Array:
    """(T, 6+J) or (T, J) from wrenches (T, N, 6) on each body about the base origin, base frame."""
    S, carried = joint_motions(tree, q), tree.subtree.astype(np.float64)
    joints = np.zeros((len(q), len(tree.joints)))
    moved = np.flatnonzero(tree.dof >= 0)
    joints[:, tree.dof[moved]] = np.einsum("tia,tia->ti", S, np.einsum("ik,tka->tia", carried, wrench))[:, moved]
    return np.concatenate([wrench.sum(axis=1), joints], axis=1) if tree.floating else joints


def to_base(states: BodyStates, wrench: Array) -> Array:
    return _shift(states.rotation, states.position, wrench)


def _shift(R: Array, p: Array, wrench: Array) -> Array:
    """Columns of wrenches (..., 6, K) about a body's origin in its frame, to the base origin and frame."""
    force = R @ wrench[..., :3, :]
    moment = R @ wrench[..., 3:, :] + _skew(p) @ force
    return np.concatenate([force, moment], axis=-2)


def _skew(v: Array) -> Array:
    """(..., 3, 3) with skew(v) @ u = v x u."""
    out = np.zeros((*v.shape, 3))
    out[..., 2, 1] = v[..., 0]
    out[..., 0, 2] = v[..., 1]
    out[..., 1, 0] = v[..., 2]
    return out - np.swapaxes(out, -1, -2)


def _inertia_columns(x: Array) -> Array:
    """(..., 3, 6) L with L(x) [Ixx, Ixy, Iyy, Ixz, Iyz, Izz] = I x."""
    out = np.zeros((*x.shape, 6))
    for row, column, component in (
        (0, 0, 0), (0, 1, 1), (0, 3, 2), (1, 1, 0), (1, 2, 1), (1, 4, 2), (2, 3, 0), (2, 4, 1), (2, 5, 2),
    ):  # fmt: skip
        out[..., row, column] = x[..., component]
    return out


def cut_regressor(tree: RigidTree, motion: Motion, frame: str) -> Array:
    """(T, 6, 10N) wrench that moves the bodies beyond a sensor, per standard parameter.

    Force then moment about the origin of the sensor's frame, in its axes.
    """
    wrench, states = wrench_regressor(tree, motion)
    Y = np.zeros((motion.samples, 6, len(tree.bodies), 10))
    beyond = list(tree.cuts[frame])
    Y[:, :, beyond] = np.swapaxes(wrench[:, beyond], 1, 2)
    return in_sensor_frame(tree, frame, states, Y.reshape(motion.samples, 6, -1))


def cut_wrench(tree: RigidTree, motion: Motion, frame: str, phi: Array) -> Array:
    """(T, 6) Y φ without building Y. phi: (N, 10)."""
    wrench, states = moving_wrenches(tree, motion, phi)
    return in_sensor_frame(tree, frame, states, wrench[:, list(tree.cuts[frame])].sum(axis=1)[:, :, None])[:, :, 0]


def in_sensor_frame(tree: RigidTree, frame: str, states: BodyStates, wrench: Array) -> Array:
    """(T, 6, K) wrenches about the base origin in the base frame, about a sensor's origin in its axes."""
    samples = len(wrench)
    body, T = tree.frames[frame]
    R, p = np.tile(T.rotation, (samples, 1, 1)), np.tile(T.translation, (samples, 1))
    if body >= 0:
        p = states.position[:, body] + np.einsum("tij,j->ti", states.rotation[:, body], T.translation)
        R = states.rotation[:, body] @ T.rotation
    force, moment = wrench[:, :3], wrench[:, 3:]
    moment = moment - np.cross(p[:, :, None], force, axis=1)
    return np.concatenate([np.einsum("tji,tjk->tik", R, each) for each in (force, moment)], axis=1)
