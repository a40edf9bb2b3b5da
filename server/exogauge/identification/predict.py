"""What a parameter set says the sensors should have read, on a log's own sample times."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.equations import TOLD, Equations
from exogauge.identification.preparation import BASE_CHANNELS, Prepared, drive_on_axes, wrench_channels, wrenches
from exogauge.robots.description import Robot

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Parameters:
    """phi: (N, 10). xi: (A, K) in the order of the equations' effects. added: (E,) of their added columns."""

    phi: Array
    xi: Array
    added: Array = field(default_factory=lambda: np.zeros(0))


def split(equations: Equations, standard: Array) -> Parameters:
    """standard: (S,) [φ; ξ]."""
    phi = equations.robot.tree.phi
    own = phi.size + len(equations.robot.joints) * len(equations.effects)
    xi = standard[phi.size : own].reshape(len(equations.robot.joints), len(equations.effects))
    return Parameters(standard[: phi.size].reshape(phi.shape), xi, standard[own:])


def motor_gain(equations: Equations, parameters: Parameters) -> Array:
    """(A,) k_T; 1 where the motor's gain is not part of the model."""
    gain = [k for k, effect in enumerate(equations.effects) if effect.name == "motor_gain"]
    return parameters.xi[:, gain[0]] if gain else np.ones(len(parameters.xi))


def of_x(equations: Equations, alternatives: Sequence[Parameters]) -> Array:
    """(P, L) what the rows of the equations see of parameter sets."""
    every = [(equations.base.regroup @ each.phi.ravel(), each.xi.ravel(), each.added) for each in alternatives]
    return np.column_stack([np.concatenate(each) for each in every])


def measured_channels(equations: Equations, prepared: Prepared, k_T: Array) -> Mapping[str, Array]:
    """Unfiltered base wrench (from the contact sensors), joint torques k_T u, or the torques as logged, and readings of
    the sensors that carry bodies."""
    robot = equations.robot
    wrench = equations.acting(prepared, wrenches(robot.contacts, prepared.log))[:, equations.layout.base]
    channels = dict(zip(BASE_CHANNELS, wrench.T, strict=True)) if robot.floating else {}
    torque = robot.on_joints(drive_on_axes(robot, prepared.log) * k_T)
    for index, joint in enumerate(robot.joints):
        if joint.actuation != "none":
            channels[f"tau.{joint.name}"] = torque[:, index]
    for sensor in robot.cuts:
        channels |= {name: prepared.log.channels[name] for name in wrench_channels(sensor.name)}
    return channels


def told_channels(robot: Robot) -> tuple[str, ...]:
    """Names of what is measured and predicted, in this order."""
    torques = [f"tau.{joint.name}" for joint in robot.joints if joint.actuation != "none"]
    read = [name for sensor in robot.cuts for name in wrench_channels(sensor.name)]
    return (*(BASE_CHANNELS if robot.floating else ()), *torques, *read)


def predictions(
    equations: Equations, prepared: Prepared, alternatives: Sequence[Parameters]
) -> list[Mapping[str, Array]]:
    """Base wrench Y_o φ, the joint torques that the motors must give, Y_j φ - F_j + friction - offset, and readings of
    sensors; of several parameter sets, for all of which the rows of the equations are built once.

    At rest static friction is τ_s with the sign of the low-passed residual torque ([Evaluator] (8)-(9)): there the
    prediction knows from the measurement which way the joint sticks, and nothing more.
    """
    view, axes = prepared.as_stored(equations.robot), equations.layout.told.axes
    gains = [k for k, effect in enumerate(equations.effects) if effect.name == "motor_gain"]
    others = []
    for each in alternatives:
        xi = each.xi.copy()
        xi[:, gains] = 0.0
        others.append(replace(each, xi=xi))
    every = view.signals()
    asked = equations.asked(prepared, every, view.added, of_x(equations, others))
    asked[:, axes] -= equations.outside(prepared)[:, axes].T
    for axis, signals in enumerate(every):
        if signals.rest.any():
            for needed, whole, other in zip(asked[:, axes][:, axis], alternatives, others, strict=True):
                r = prepared.drive[:, axis] * whole.xi[axis, gains].sum() - needed
                stuck = replace(signals, stick=signals.rest * np.sign(r))
                for effect, coefficient in zip(equations.effects, other.xi[axis], strict=True):
                    needed -= (effect.column(stuck) - effect.column(signals)) * coefficient
    return [_named(equations, each) for each in asked]


def added_beyond_band(equations: Equations, prepared: Prepared, parameters: Parameters) -> Mapping[str, Array]:
    """Channel -> (T,) what the low-pass would take off the part of `predictions` that added columns give; all else
    that is predicted in steady motion has passed it."""
    beyond = np.zeros((len(equations.layout.told), prepared.log.samples))
    for kind, own in zip(equations.layout.numbers(*TOLD), beyond, strict=True):
        columns, entries = equations.added_to(kind)
        if len(columns):
            own -= (prepared.raw_added[:, entries] - prepared.added[:, entries]) @ parameters.added[columns]
    return _named(equations, beyond)


def _named(equations: Equations, told: Array) -> Mapping[str, Array]:
    """Channel -> (T,). told: (told rows, T), torques on actuator axes, and what holds the bodies beyond sensors. Of
    joint torques those of the joints whose drive is logged; of sensors their readings as they are logged."""
    robot, layout = equations.robot, equations.layout.told
    channels = dict(zip(BASE_CHANNELS, told[layout.base], strict=True)) if robot.floating else {}
    for joint, torque in zip(robot.joints, robot.on_joints(told[layout.axes].T).T, strict=True):
        if joint.actuation != "none":
            channels[f"tau.{joint.name}"] = torque
    for index, sensor in enumerate(robot.cuts):
        channels |= zip(wrench_channels(sensor.name), -sensor.sign * told[layout.sensor(index)], strict=True)
    return channels
