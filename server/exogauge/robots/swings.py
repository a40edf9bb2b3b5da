"""What each axis turns, and how the pull of gravity changes with its angle, in closed form."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.robots.kinematics import Kinematics, cross
from exogauge.robots.motion import Motion
from exogauge.robots.regressor import inertia_matrices
from exogauge.robots.tree import RigidTree

Array = NDArray[np.float64]


def inertia_and_gravity_slope(
    tree: RigidTree, axes_from_joints: Array, phi: Array, motion: Motion
) -> tuple[Array, Array]:
    """(T, A) inertia [kg·m²] about each axis, and slope [N·m/rad] of its torque over its angle, all else held.

    phi: (N, 10). motion: its postures and its `acc` count.

    A joint moves the point c at v + w × c, so that of what it carries (mass m, first moment h, inertia I about the
    base origin) the mass matrix holds M_ij = [v_i; w_i] · [m v_j + w_j × h; h × v_j + I w_j] for i above j, and the
    potential acc · h has the second derivative acc · (w_i × (m v_j + w_j × h)).
    """
    still = np.zeros_like(motion.q)
    none = np.zeros((motion.samples, 3))
    sweep = Kinematics(tree).sweep(Motion(motion.q, still, still, none, none, none))
    m, h, inertia = _carried(tree, phi, sweep.R, sweep.p)
    v, w = sweep.S[:, :3], sweep.S[:, 3:]
    body = {int(joint): int(k) for k, joint in enumerate(tree.dof) if joint >= 0}
    above, acc = tree.subtree, motion.acc.T
    J, K = np.zeros_like(motion.q), np.zeros_like(motion.q)
    for axis, turn in enumerate(np.linalg.inv(axes_from_joints).T):
        moved = [(body[int(joint)], float(turn[joint])) for joint in np.flatnonzero(turn)]
        for j, weight in moved:
            linear = m[j] * v[j] + cross(w[j], h[j], axis=0)
            angular = cross(h[j], v[j], axis=0) + np.einsum("xyt,yt->xt", inertia[j], w[j])
            for i, other in moved:
                if above[i, j]:
                    share = weight * other * (1.0 if i == j else 2.0)
                    J[:, axis] += share * (np.sum(v[i] * linear, axis=0) + np.sum(w[i] * angular, axis=0))
                    K[:, axis] += share * np.sum(acc * cross(w[i], linear, axis=0), axis=0)
    return J, K


def _carried(tree: RigidTree, phi: Array, R: Array, p: Array) -> tuple[Array, Array, Array]:
    """m (N,), h (N, 3, T), I (N, 3, 3, T) of each body with all that it carries, about the base origin."""
    m, first = phi[:, 0].copy(), np.einsum("nijt,nj->nit", R, phi[:, 1:4])
    turned = np.einsum("nijt,njk->nikt", R, inertia_matrices(phi))
    inertia = np.einsum("nikt,njkt->nijt", turned, R)
    h = first + m[:, None, None] * p
    eye = np.eye(3)[None, :, :, None]
    # from the body's origin, about which its first moment is f: I + (2 p·f + m p·p) 1 - (p fᵀ + f pᵀ + m p pᵀ)
    inertia += np.sum(2.0 * p * first + m[:, None, None] * p * p, axis=1)[:, None, None] * eye
    crossed = p[:, :, None] * first[:, None]
    inertia -= crossed + np.swapaxes(crossed, 1, 2) + m[:, None, None, None] * p[:, :, None] * p[:, None]
    for k in range(len(m) - 1, -1, -1):
        up = tree.parent[k]
        if up >= 0:
            m[up] += m[k]
            h[up] += h[k]
            inertia[up] += inertia[k]
    return m, h, inertia
