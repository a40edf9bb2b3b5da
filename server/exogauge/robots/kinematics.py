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
    acceleration of the body's origin. B: (N, 3, 3, T) [α]× + [ω]×², which takes a point of the body to its acceleration
    relative to the origin. S: (N, 6, T) [linear; angular] motion about the base origin that a unit velocity
    of the body's own joint gives to all it carries; torque = S · [force; moment about the base origin]; 0 for the base.
    """

    R: Array
    p: Array
    omega: Array
    alpha: Array
    b: Array
    B: Array
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
        """Outward over the bodies: rotations by products, all else by sums of what each joint adds.

        Entry n of the arrays below is the base link, so that parent -1 finds it; a dof of -1 finds a joint at rest.
        """
        tree, n, samples = self.tree, len(self.tree.bodies), motion.samples
        rest = np.zeros((1, samples))
        q, dq, ddq = (np.concatenate([x.T, rest])[tree.dof][:, None] for x in (motion.q, motion.dq, motion.ddq))
        slides = np.flatnonzero(tree.prismatic)
        offset = np.flatnonzero(self.offset_in_body.any(axis=1))

        E = self.E_c[..., None] * np.cos(q)[:, None]
        E += self.E_s[..., None] * np.sin(q)[:, None]
        E += self.E_0[..., None]
        R = np.empty((n + 1, 3, 3, samples))
        R[n] = np.eye(3)[:, :, None]
        for i, up in enumerate(tree.parent):
            np.einsum("ikt,kjt->ijt", R[up], E[i], out=R[i])

        above = R[tree.parent]
        a = np.einsum("nijt,nj->nit", above, self.axis_in_parent)
        r = np.einsum("nijt,nj->nit", above, self.p_before)
        r[slides] += a[slides] * q[slides]
        s = np.einsum("nijt,nj->nit", R[offset], self.offset_in_body[offset])
        step = r.copy()
        step[offset] += s
        p = self._summed(np.zeros((3, samples)), step)

        turn = a * dq
        slide = turn[slides]
        turn[slides] = 0.0
        omega = self._summed(motion.gyro.T, turn)
        step = cross(omega[tree.parent], turn, axis=1)
        step += np.where(tree.prismatic[:, None, None], 0.0, a * ddq)
        alpha = self._summed(motion.gyro_dot.T, step)

        B = _rigid(omega, alpha)
        step = np.einsum("nijt,njt->nit", B[tree.parent], r)
        step[slides] += a[slides] * ddq[slides] + 2.0 * cross(omega[tree.parent][slides], slide, axis=1)
        step[offset] += np.einsum("nijt,njt->nit", B[offset], s)
        b = self._summed(motion.acc.T, step)

        S = np.empty((n, 6, samples))
        S[:, :3] = cross(p[tree.parent] + r, a, axis=1)
        S[:, 3:] = a
        S[slides, :3] = a[slides]
        S[slides, 3:] = 0.0
        return Sweep(R[:n], p[:n], omega[:n], alpha[:n], b[:n], B[:n], S)

    def _summed(self, base: Array, steps: Array) -> Array:
        """(N+1, 3, T) the base's value plus the (N, 3, T) steps on the way to each body."""
        total = np.empty((len(steps) + 1, *steps.shape[1:]))
        total[-1] = base
        for i, up in enumerate(self.tree.parent):
            np.add(total[up], steps[i], out=total[i])
        return total


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


def cross(u: Array, v: Array, axis: int = -1) -> Array:
    """u x v along an axis of three, as NumPy's, which takes several times as long for what it may be given else."""
    out = np.empty(np.broadcast_shapes(u.shape, v.shape))
    a, b, found = (np.moveaxis(each, axis, 0) for each in (u, v, out))
    for x, y, z in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        np.multiply(a[y], b[z], out=found[x, ...])
        found[x] -= a[z] * b[y]
    return out


def _rigid(omega: Array, alpha: Array) -> Array:
    """(N, 3, 3, T) [α]× + [ω]×², with [ω]×² = ω ωᵀ − |ω|² 1."""
    B = omega[:, :, None] * omega[:, None]
    square = B[:, 0, 0] + B[:, 1, 1] + B[:, 2, 2]
    for x, y, z in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        B[:, x, x] -= square
        B[:, y, x] += alpha[:, z]
        B[:, x, y] -= alpha[:, z]
    return B
