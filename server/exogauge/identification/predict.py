"""What a parameter set says the sensors should have read, on a log's own sample times."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.contacts import ContactPaths
from exogauge.identification.equations import CHUNK, Equations
from exogauge.identification.preparation import BASE_CHANNELS, Prepared, wrench_channels
from exogauge.robots.rows import RowType

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


def measured_channels(equations: Equations, prepared: Prepared, k_T: Array) -> Mapping[str, Array]:
    """Unfiltered base wrench (from the contact sensors), joint torques k_T u, or the torques as logged, and readings of
    the sensors that carry bodies."""
    robot = equations.robot
    channels: dict[str, Array] = {}
    if robot.floating:
        wrench, contacts = np.empty((prepared.log.samples, 6)), ContactPaths(robot)
        for which in _chunks(prepared.log.samples):
            wrench[which] = contacts.effect(prepared.motion.q[which], prepared.raw_wrenches[which])[:, :6]
        channels.update(zip(BASE_CHANNELS, wrench.T, strict=True))
    torque = (prepared.raw_drive * k_T) @ robot.axes_from_joints
    for index, joint in enumerate(robot.joints):
        if joint.actuation != "none":
            channels[f"tau.{joint.name}"] = torque[:, index]
    for sensor in robot.cuts:
        channels |= {name: prepared.log.channels[name] for name in wrench_channels(sensor.name)}
    return channels


def predicted_channels(equations: Equations, prepared: Prepared, parameters: Parameters) -> Mapping[str, Array]:
    """Base wrench Y_o φ and the joint torques that the motors must give: Y_j φ - F_j + friction - offset.

    At rest static friction is τ_s with the sign of the low-passed residual torque ([Evaluator] (8)-(9)): there the
    prediction knows from the measurement which way the joint sticks, and nothing more.
    """
    return predictions(equations, prepared, [parameters])[0]


def predictions(
    equations: Equations, prepared: Prepared, alternatives: Sequence[Parameters]
) -> list[Mapping[str, Array]]:
    """`predicted_channels` of several parameter sets; the rows of the equations are built once for all."""
    rows, layout = equations.blocks, equations.layout
    phi = [equations.base.regroup @ parameters.phi.ravel() for parameters in alternatives]
    predicted = np.empty((len(alternatives), len(rows.columns), prepared.log.samples))
    carried = np.empty((len(alternatives), len(layout.numbers(RowType.SENSOR)), prepared.log.samples))
    contacts, blocks = ContactPaths(equations.robot), None
    for which in _chunks(prepared.log.samples):
        motion = prepared.motion.rows(which)
        blocks = rows.fill(motion, 0, blocks)
        external = contacts.effect(motion.q, prepared.wrenches[which]).T
        smeared = prepared.smeared[which].T
        beyond = [pair for cut in equations.cuts for pair in zip(cut.fill(motion), cut.columns, strict=True)]
        for one, on_sensors, phi_base, parameters in zip(predicted, carried, phi, alternatives, strict=True):
            for kind, (block, columns) in enumerate(zip(blocks, rows.columns, strict=True)):
                one[kind, which] = block @ phi_base[columns]
            for kind in layout.numbers(RowType.BASE):
                one[kind, which] -= _added(equations, prepared, parameters, kind, which)
            one[layout.axes, which] += smeared[layout.told.axes] - external[layout.axes]
            for axis, needed in enumerate(one[layout.axes, which]):
                needed -= _friction_and_offset(equations, prepared, parameters, axis, which, needed)
            for row, (kind, (block, columns)) in enumerate(zip(layout.numbers(RowType.SENSOR), beyond, strict=True)):
                added = _added(equations, prepared, parameters, kind, which)
                on_sensors[row, which] = block @ phi_base[columns] + smeared[layout.told.sensors][row] - added
    return [_named(equations, *both) for both in zip(predicted, carried, strict=True)]


def added_beyond_band(equations: Equations, prepared: Prepared, parameters: Parameters) -> Mapping[str, Array]:
    """Channel -> (T,) what the low-pass would take off the part of `predicted_channels` that added columns give; all
    else that is predicted in steady motion has passed it."""
    layout, samples = equations.layout, prepared.log.samples
    beyond = prepared.raw_added - prepared.added

    def on(kind: int) -> Array:
        columns, entries = equations.added_to(kind)
        return np.asarray(-beyond[:, entries] @ parameters.added[columns]) if len(columns) else np.zeros(samples)

    own = [on(kind) for kind in layout.numbers(RowType.BASE, RowType.AXIS)]
    carried = [on(kind) for kind in layout.numbers(RowType.SENSOR)]
    return _named(equations, np.array(own), np.array(carried).reshape(-1, samples))


def _added(equations: Equations, prepared: Prepared, parameters: Parameters, kind: int, which: slice) -> Array | float:
    """(n,) what added columns take off the rows of one kind, unfiltered."""
    columns, entries = equations.added_to(kind)
    return np.asarray(prepared.raw_added[which][:, entries] @ parameters.added[columns]) if len(columns) else 0.0


def _friction_and_offset(
    equations: Equations, prepared: Prepared, parameters: Parameters, axis: int, which: slice, needed: Array
) -> Array:
    """(n,) torque that all effects but the motor's own give. needed: (n,) Y_j φ - F_j."""
    model = list(zip(equations.effects, parameters.xi[axis], strict=True))
    gain = sum(c for effect, c in model if effect.name == "motor_gain")
    others = [(effect, c) for effect, c in model if effect.name != "motor_gain"]
    signals, none = prepared.raw_signals(axis, which, np.zeros(len(needed))), np.zeros(len(needed))
    added = none + _added(equations, prepared, parameters, equations.layout.axis(axis), which)
    torque = sum((effect.column(signals) * c for effect, c in others), start=added)
    if not signals.rest.any():
        return torque
    r = gain * prepared.drive[which, axis] + torque - needed
    signals = replace(signals, stick=signals.rest * np.sign(r))
    return sum((effect.column(signals) * c for effect, c in others), start=added)


def _named(equations: Equations, predicted: Array, carried: Array) -> Mapping[str, Array]:
    """predicted: (rows, T), axis torques on actuator axes; joint torques of the joints whose drive is logged.

    carried: (6 C, T) what holds the bodies beyond sensors; their readings as they are logged.
    """
    robot, layout = equations.robot, equations.layout
    channels = dict(zip(BASE_CHANNELS, predicted[layout.base], strict=True)) if robot.floating else {}
    on_joints = robot.axes_from_joints.T @ predicted[layout.axes]
    for joint, torque in zip(robot.joints, on_joints, strict=True):
        if joint.actuation != "none":
            channels[f"tau.{joint.name}"] = torque
    for index, sensor in enumerate(robot.cuts):
        channels |= zip(wrench_channels(sensor.name), -sensor.sign * carried[6 * index : 6 * index + 6], strict=True)
    return channels


def _chunks(samples: int) -> list[slice]:
    return [slice(start, min(start + CHUNK, samples)) for start in range(0, samples, CHUNK)]
