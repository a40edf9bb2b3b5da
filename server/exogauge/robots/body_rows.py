"""What one body asks of every axis, the base and the sensors that carry it, per inertial parameter of its own."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from exogauge.robots.kinematics import BodyStates, forward, joint_motions
from exogauge.robots.motion import Motion
from exogauge.robots.regressor import body_regressor, in_sensor_frame, to_base
from exogauge.robots.tree import RigidTree

Array = NDArray[np.float64]


def body_rows(tree: RigidTree, axes_from_joints: Array, motion: Motion, body: int, cuts: Sequence[str] = ()) -> Array:
    """(T, 6 + A + 6 C, 10), or without the six base rows for a fixed base: the columns of one body in Y.

    Base force and moment about the base link's origin, in its frame; actuator axes; then, for the frame of each sensor
    in `cuts`, force and moment about its origin, in its axes, 0 where it does not carry the body.
    """
    chunk = 2000  # samples at once: 30 MB of states of a humanoid
    starts = range(0, motion.samples, chunk)
    parts = [_rows(tree, axes_from_joints, motion.rows(slice(k, k + chunk)), body, cuts) for k in starts]
    return np.concatenate(parts)


def _rows(tree: RigidTree, axes_from_joints: Array, motion: Motion, body: int, cuts: Sequence[str]) -> Array:
    states, S = forward(tree, motion), joint_motions(tree, motion.q)
    wrench = to_base(_only(states, body), body_regressor(_only(states, body)))[:, 0]
    joints = np.zeros((motion.samples, len(tree.joints), 10))
    for i in np.flatnonzero(tree.subtree[:, body] & (tree.dof >= 0)):
        joints[:, tree.dof[i]] = np.einsum("ta,tak->tk", S[:, i], wrench)
    axes = np.einsum("ja,tjk->tak", np.linalg.inv(axes_from_joints), joints)  # C⁻ᵀ τ
    read = [in_sensor_frame(tree, frame, states, wrench * (body in tree.cuts[frame])) for frame in cuts]
    return np.concatenate([*([wrench] if tree.floating else []), axes, *read], axis=1)


def _only(states: BodyStates, body: int) -> BodyStates:
    return BodyStates(
        *(
            each[:, [body]]
            for each in (
                states.rotation,
                states.position,
                states.omega,
                states.alpha,
                states.proper_acceleration,
            )
        )
    )
