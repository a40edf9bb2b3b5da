"""What a parameter set says the sensors should have read, on a log's own sample times."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.equations import CHUNK, Equations, external_effect
from exogauge.identification.preparation import Prepared
from exogauge.robots.regressor import inverse_dynamics

Array = NDArray[np.float64]

BASE_CHANNELS = ("base.fx", "base.fy", "base.fz", "base.mx", "base.my", "base.mz")


@final
@dataclass(frozen=True)
class Parameters:
    """phi: (N, 10). xi: (A, K) in the order of the equations' effects."""

    phi: Array
    xi: Array


def split(equations: Equations, standard: Array) -> Parameters:
    """standard: (S,) [φ; ξ]."""
    phi = equations.robot.tree.phi
    xi = standard[phi.size :].reshape(len(equations.robot.joints), len(equations.effects))
    return Parameters(standard[: phi.size].reshape(phi.shape), xi)


def motor_gain(equations: Equations, parameters: Parameters) -> Array:
    """(A,) k_T; 1 where the motor's gain is not part of the model."""
    gain = [k for k, effect in enumerate(equations.effects) if effect.name == "motor_gain"]
    return parameters.xi[:, gain[0]] if gain else np.ones(len(parameters.xi))


def measured_channels(equations: Equations, prepared: Prepared, k_T: Array) -> Mapping[str, Array]:
    """Unfiltered base wrench (from the contact sensors) and joint torques k_T u, or the torques as logged."""
    robot = equations.robot
    channels: dict[str, Array] = {}
    if robot.floating:
        wrench = np.empty((prepared.log.samples, 6))
        for which in _chunks(prepared.log.samples):
            wrench[which] = external_effect(robot, prepared.motion.q[which], prepared.raw_wrenches[which])[:, :6]
        channels.update(zip(BASE_CHANNELS, wrench.T, strict=True))
    torque = (prepared.raw_drive * k_T) @ robot.axes_from_joints
    for index, joint in enumerate(robot.joints):
        if joint.actuation != "none":
            channels[f"tau.{joint.name}"] = torque[:, index]
    return channels


def predicted_channels(equations: Equations, prepared: Prepared, parameters: Parameters) -> Mapping[str, Array]:
    """Base wrench Y_o φ and the joint torques that the motors must give: Y_j φ - F_j + friction - offset.

    At rest static friction is τ_s with the sign of the low-passed residual torque ([Evaluator] (8)-(9)): there the
    prediction knows from the measurement which way the joint sticks, and nothing more.
    """
    robot = equations.robot
    first, axes = equations.first_axis, len(robot.joints)
    gain = [k for k, effect in enumerate(equations.effects) if effect.name == "motor_gain"]
    predicted = np.empty((prepared.log.samples, first + axes))
    to_axes = np.linalg.inv(robot.axes_from_joints)
    for which in _chunks(prepared.log.samples):
        rigid = inverse_dynamics(robot.tree, prepared.motion.rows(which), parameters.phi)
        external = external_effect(robot, prepared.motion.q[which], prepared.wrenches[which])
        predicted[which, :first] = rigid[:, :first]
        needed = rigid[:, first:] @ to_axes - external[:, first:]
        for axis in range(axes):
            xi = parameters.xi[axis].copy()
            drive = sum(xi[k] for k in gain) * prepared.drive[which, axis]
            xi[gain] = 0.0
            zero = np.zeros(len(needed))
            smooth = prepared.raw_signals(axis, which, zero)
            others = sum(e.column(smooth) * c for e, c in zip(equations.effects, xi, strict=True))
            r = drive + others - needed[:, axis]
            signals = prepared.raw_signals(axis, which, smooth.rest * np.sign(r))
            torque = sum(e.column(signals) * c for e, c in zip(equations.effects, xi, strict=True))
            predicted[which, first + axis] = needed[:, axis] - torque
    channels = dict(zip(BASE_CHANNELS, predicted[:, :6].T, strict=True)) if first else {}
    on_joints = predicted[:, first:] @ robot.axes_from_joints
    for index, joint in enumerate(robot.joints):
        if joint.actuation != "none":
            channels[f"tau.{joint.name}"] = on_joints[:, index]
    return channels


def _chunks(samples: int) -> list[slice]:
    return [slice(start, min(start + CHUNK, samples)) for start in range(0, samples, CHUNK)]
