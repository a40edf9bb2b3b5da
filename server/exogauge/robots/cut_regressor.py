"""The regressor of a force/torque sensor inside the robot, dense: the reference for `cut_rows`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.robots.kinematics import BodyStates
from exogauge.robots.motion import Motion
from exogauge.robots.regressor import moving_wrenches, wrench_regressor
from exogauge.robots.tree import RigidTree

Array = NDArray[np.float64]


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
