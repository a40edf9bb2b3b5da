"""What an axis turns: the inertia of the links beyond it, and how gravity's pull changes with its angle."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.equations import Equations
from exogauge.identification.preparation import Prepared
from exogauge.robots.motion import Motion

if TYPE_CHECKING:
    from exogauge.identification.model import RobotModel

Array = NDArray[np.float64]

EVERY_S = 0.1  # [s] between samples that are computed; both change with the posture alone
NUDGE = 1e-3  # [rad] for the slope
LEAST = 0.02  # of the usual inertia, in any posture


def swings(model: RobotModel, prepared: Prepared, axes: Sequence[int]) -> tuple[Array, Array]:
    """inertia (T, axes) [kg·m²] about some axes and slope (T, axes) [N·m/rad] of the load over their angle, all other
    axes and the base held; computed once for each log."""
    at, *values = model.computed.of(prepared.log, "swings", lambda: _swings(model, prepared))
    every = np.arange(prepared.log.samples)
    inertia, slope = (np.column_stack([np.interp(every, at, each[:, axis]) for axis in axes]) for each in values)
    return np.maximum(inertia, LEAST * np.abs(model.sizes.inertia[list(axes)])), slope


def _swings(model: RobotModel, prepared: Prepared) -> tuple[Array, Array, Array]:
    """(n,) samples at which both are computed, for all axes."""
    phi = model.bodies_in(prepared.log.recording)
    stride = max(1, round(EVERY_S * prepared.log.rate_hz))
    at = np.unique(np.append(np.arange(0, prepared.log.samples, stride), prepared.log.samples - 1))
    return at, *inertia_and_slope(model.equations, phi, prepared.motion.rows(at))


def inertia_and_slope(equations: Equations, phi: Array, motion: Motion) -> tuple[Array, Array]:
    """(T, A) each. phi: (B,) base parameters."""
    turns = np.linalg.inv(equations.robot.axes_from_joints)
    still, nowhere = np.zeros_like(motion.q), np.zeros((motion.samples, 3))
    inertia, slope = np.empty_like(motion.q), np.empty_like(motion.q)

    def torque(axis: int, q: Array, ddq: Array, acc: Array) -> Array:
        return equations.of_bodies_on(equations.layout.axis(axis), Motion(q, still, ddq, acc, nowhere, nowhere), phi)

    for axis in range(motion.q.shape[1]):
        turn = turns[:, axis]
        inertia[:, axis] = torque(axis, motion.q, still + turn, nowhere)
        ahead, behind = (torque(axis, motion.q + side * NUDGE * turn, still, motion.acc) for side in (1.0, -1.0))
        slope[:, axis] = (ahead - behind) / (2.0 * NUDGE)
    return inertia, slope
