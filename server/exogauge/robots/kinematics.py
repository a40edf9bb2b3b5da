"""Where every body is and how it moves, for all samples at once, seen from a base link that carries an IMU.

No base pose or velocity is needed ([Evaluator] section 3.2): the base link's frame is the world, gravity is zero, and
its proper acceleration takes the place of both.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from exogauge.robots.motion import Motion
from exogauge.robots.tree import RigidTree

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class BodyStates:
    """T samples of N bodies.

    rotation: (T, N, 3, 3) R_base_body. position: (T, N, 3) [m] of the body's origin, base frame.
    omega, alpha: (T, N, 3) [rad/s, rad/s²] angular velocity and acceleration, body frame.
    proper_acceleration: (T, N, 3) [m/s²] a − g of the body's origin, body frame.
    """

    rotation: Array
    position: Array
    omega: Array
    alpha: Array
    proper_acceleration: Array


@final
@dataclass(frozen=True)
class Sweep:
    """The same in the base link's frame, time last, as the batched kernels want it.

    R: (N, 3, 3, T) R_base_body. p, omega, alpha, b: (N, 3, T) position, angular velocity and acceleration, proper
    acceleration of the body's origin. S: (N, 6, T) [linear; angular] motion about the base origin that a unit velocity
    of the body's own joint gives to all it carries; torque = S · [force; moment about the base origin]; 0 for the base.
    """

    R: Array
    p: Array
    omega: Array
    alpha: Array
    b: Array
    S: Array


@final
class Kinematics:
    """The constants of a tree that a sweep needs, computed once."""

    def __init__(self, tree: RigidTree) -> None:
        self.tree = tree
        n = len(tree.bodies)
        self.R_before, self.R_after = (
            np.array([T.rotation for T in poses]).reshape(n, 3, 3) for poses in (tree.T_before, tree.T_after)
        )
        self.p_before, p_after = (
            np.array([T.translation for T in poses]).reshape(n, 3) for poses in (tree.T_before, tree.T_after)
        )
        skew = np.array([pin.skew(a) for a in tree.axis]).reshape(n, 3, 3)
        # R_parent_body(q) = E_0 + E_c cos q + E_s sin q (Rodrigues), for a prismatic joint constant
        along = tree.axis[:, :, None] * tree.axis[:, None, :]
        turns = (~tree.prismatic & (tree.dof >= 0))[:, None, None]
        self.E_0 = self.R_before @ np.where(turns, along, np.eye(3)) @ self.R_after
        self.E_c = self.R_before @ np.where(turns, np.eye(3) - along, 0.0) @ self.R_after
        self.E_s = self.R_before @ np.where(turns, skew, 0.0) @ self.R_after
        self.axis_in_parent = np.einsum("nij,nj->ni", self.R_before, tree.axis)
        self.offset_in_body = np.einsum("nji,nj->ni", self.R_after, p_after)  # from joint to body origin

    def sweep(self, motion: Motion) -> Sweep:
        """Outward recursion over the bodies, each for all samples."""
        tree, samples, n = self.tree, motion.samples, len(self.tree.bodies)
        q, dq, ddq = (np.ascontiguousarray(x.T) for x in (motion.q, motion.dq, motion.ddq))
        base = tuple(np.ascontiguousarray(x.T) for x in (motion.gyro, motion.gyro_dot, motion.acc))
        R = np.empty((n, 3, 3, samples))
        p, omega, alpha, b = (np.empty((n, 3, samples)) for _ in range(4))
        S = np.zeros((n, 6, samples))
        cos, sin = np.cos(q), np.sin(q)
        still = np.zeros((3, samples))
        for i in range(n):
            j, up = tree.dof[i], tree.parent[i]
            if j < 0:
                R[i] = np.eye(3)[:, :, None]
                p[i] = 0.0
                omega[i], alpha[i], b[i] = base
                continue
            R_up = R[up] if up >= 0 else None
            p_up, w_up, dw_up, b_up = (p[up], omega[up], alpha[up], b[up]) if up >= 0 else (still, *base)
            E = self.E_0[i][:, :, None]
            if not tree.prismatic[i]:
                E = E + self.E_c[i][:, :, None] * cos[j] + self.E_s[i][:, :, None] * sin[j]
            a = _turn(R_up, self.axis_in_parent[i], samples)
            r = _turn(R_up, self.p_before[i], samples)
            if R_up is None:
                R[i] = E
            else:
                np.einsum("ikt,kjt->ijt", R_up, np.broadcast_to(E, (3, 3, samples)), out=R[i])
            if tree.prismatic[i]:
                r += a * q[j]
            b_joint = b_up + _cross(dw_up, r) + _cross(w_up, _cross(w_up, r))
            if tree.prismatic[i]:
                omega[i], alpha[i] = w_up, dw_up
                b_joint += a * ddq[j] + 2.0 * _cross(w_up, a * dq[j])
                S[i, :3] = a
            else:
                omega[i] = w_up + a * dq[j]
                alpha[i] = dw_up + a * ddq[j] + _cross(w_up, a * dq[j])
                S[i, :3] = _cross(p_up + r, a)
                S[i, 3:] = a
            if self.offset_in_body[i].any():
                s = _turn(R[i], self.offset_in_body[i], samples)
                b_joint += _cross(alpha[i], s) + _cross(omega[i], _cross(omega[i], s))
                r += s
            p[i] = p_up + r
            b[i] = b_joint
        return Sweep(R, p, omega, alpha, b, S)


def forward(tree: RigidTree, motion: Motion) -> BodyStates:
    """The state of every body at every sample."""
    sweep = Kinematics(tree).sweep(motion)

    def in_body(vector: Array) -> Array:
        out: Array = np.einsum("nijt,nit->tnj", sweep.R, vector)
        return out

    return BodyStates(
        rotation=np.ascontiguousarray(np.moveaxis(sweep.R, 3, 0)),
        position=np.ascontiguousarray(np.moveaxis(sweep.p, 2, 0)),
        omega=in_body(sweep.omega),
        alpha=in_body(sweep.alpha),
        proper_acceleration=in_body(sweep.b),
    )


def joint_motions(tree: RigidTree, q: Array) -> Array:
    """(T, N, 6) [linear; angular] motion about the base origin per unit velocity of each body's joint, base frame.

    q: (T, J). Zero for the floating base.
    """
    zero, none = np.zeros_like(q), np.zeros((len(q), 3))
    sweep = Kinematics(tree).sweep(Motion(q, zero, zero, none, none, none))
    return np.ascontiguousarray(np.moveaxis(sweep.S, 2, 0))


def subtree(tree: RigidTree) -> NDArray[np.bool_]:
    """(N, N) entry [i, k]: body k is body i or carried by it."""
    n = len(tree.bodies)
    carried = np.eye(n, dtype=np.bool_)
    for k in range(n):
        if tree.parent[k] >= 0:
            carried[:, k] |= carried[:, tree.parent[k]]
    return carried


def _turn(R: Array | None, vector: Array, samples: int) -> Array:
    """(3, T) a constant vector of the frame R: (3, 3, T), None for the base itself."""
    if R is None:
        return np.repeat(vector[:, None], samples, axis=1)
    out: Array = np.einsum("ijt,j->it", R, vector)
    return out


def _cross(u: Array, v: Array) -> Array:
    """(3, T) cross product along axis 0."""
    out = np.empty_like(u)
    for x, y, z in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        np.multiply(u[y], v[z], out=out[x])
        out[x] -= u[z] * v[y]
    return out
