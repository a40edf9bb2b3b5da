"""What shaped effects see of an actuator axis: its motion, the torques that a model says it has to bear, the inertia of
the links beyond it, and how gravity's pull changes with its angle."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from exogauge.effects.shaped import AxisSignals
from exogauge.identification.equations import Equations
from exogauge.identification.model import RobotModel
from exogauge.identification.preparation import Prepared
from exogauge.identification.turns import WIDEST
from exogauge.logs.derivatives import differentiate, differentiate_twice
from exogauge.logs.filtering import LowPass
from exogauge.logs.model import Log
from exogauge.logs.undoing import StoredPositions
from exogauge.robots.motion import Motion
from exogauge.robots.swings import inertia_and_gravity_slope

Array = NDArray[np.float64]

EVERY_S = 0.1  # [s] between samples that are computed; both change with the posture alone
LEAST = 0.02  # of the usual inertia, in any posture


def axis_signals(model: RobotModel, prepared: Prepared, axes: Sequence[int]) -> list[AxisSignals]:
    """What shaped effects see of some axes of a log, at the bandwidth that its encoders can bear."""
    robot, log, own = model.robot, prepared.log, list(axes)
    moved = model.prepared.of(log, "moved", lambda: _moved(model, log))
    q, dq, ddq = (each[:, own] for each in moved)
    load = loads(model, prepared)[:, own]
    if prepared.taken_off is not None:
        load = load - prepared.taken_off[:, own]
    drive = load - model.computed.of(log, "beside", lambda: _beside_the_motor(model, prepared))[:, own]
    inertia, slope = swings(model, prepared, axes)
    result = []
    for place, axis in enumerate(axes):
        temperature = log.channels.get(f"temp.{robot.joints[axis].name}")
        usual = float(model.sizes.inertia[axis])
        known = usual > 0.0  # what is identified of a light link may fall below none
        result.append(
            AxisSignals(
                time=log.time - log.time[0],
                position=q[:, place],
                velocity=dq[:, place],
                acceleration=ddq[:, place],
                direction=prepared.raw_direction[:, axis].astype(np.float64),
                drive=drive[:, place],
                load=load[:, place],
                temperature=temperature,
                speed_scale=float(model.sizes.velocity[axis]),
                torque_scale=float(model.sizes.torque[axis]),
                range=float(model.sizes.range[axis]),
                number=model.order.get(log.name, -1),
                inertia=inertia[:, place] if known else None,
                slope=slope[:, place] if known else None,
                usual_inertia=usual if known else 1.0,
            )
        )
    return result


def _moved(model: RobotModel, log: Log) -> tuple[Array, Array, Array]:
    """(T, A) each: position, velocity and acceleration of every axis."""
    finest = LowPass(min(model.at_rest.cutoff_hz, WIDEST * log.rate_hz), log.rate_hz)
    names = [f"q.{joint.name}" for joint in model.robot.joints]
    q = model.robot.on_axes(StoredPositions(log, names, finest).before(log.stored, late=True))
    return q, differentiate(q, log.rate_hz), differentiate_twice(q, log.rate_hz)


def _beside_the_motor(model: RobotModel, prepared: Prepared) -> Array:
    """(T, A) torque of friction, offset and rotor that the model gives each axis; nothing of what holds at rest."""
    out = np.zeros((prepared.log.samples, len(model.robot.joints)))
    for axis, signals in enumerate(prepared.low_passed.signals()):
        for effect, coefficient in zip(model.equations.effects, model.identified.xi[axis], strict=True):
            if effect.name != "motor_gain":
                out[:, axis] += effect.column(signals) * coefficient
    return out


def loads(model: RobotModel, prepared: Prepared) -> Array:
    """(T, A) torque that body and outside forces ask of each axis, Y_j φ - F_j; computed once for each log."""
    return model.computed.of(prepared.log, "load", lambda: _loads(model, prepared))


def _loads(model: RobotModel, prepared: Prepared) -> Array:
    equations, axes = model.equations, model.equations.layout.told.axes
    load = equations.of_bodies(prepared.motion, model.bodies_in(prepared.log.recording), axes)
    return np.asarray(load - equations.outside(prepared)[:, axes])


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
    robot, standard = equations.robot, np.zeros(10 * len(equations.robot.tree.bodies))
    standard[equations.base.columns] = phi
    return inertia_and_gravity_slope(robot.tree, robot.axes_from_joints, standard.reshape(-1, 10), motion)
