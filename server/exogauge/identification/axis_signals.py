"""What shaped effects see of an actuator axis: its motion, and the torques that a model says it has to bear."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from exogauge.effects.shaped import AxisSignals
from exogauge.identification.contacts import ContactPaths
from exogauge.identification.preparation import Prepared
from exogauge.identification.swing import swings
from exogauge.identification.turns import WIDEST
from exogauge.logs.derivatives import differentiate, differentiate_twice
from exogauge.logs.filtering import LowPass
from exogauge.logs.undoing import StoredPositions

if TYPE_CHECKING:
    from exogauge.identification.model import RobotModel

Array = NDArray[np.float64]

CHUNK = 2000


def axis_signals(model: RobotModel, prepared: Prepared, axes: Sequence[int]) -> list[AxisSignals]:
    """What shaped effects see of some axes of a log, at the bandwidth that its encoders can bear."""
    robot, log, C = model.robot, prepared.log, model.robot.axes_from_joints[list(axes)]
    turning = np.flatnonzero(C.any(axis=0))  # joints that these axes turn
    finest = LowPass(min(model.at_rest.cutoff_hz, WIDEST * log.rate_hz), log.rate_hz)
    names = [f"q.{robot.joints[joint].name}" for joint in turning]
    q = StoredPositions(log, names, finest).before(log.stored, late=True) @ C[:, turning].T
    dq, ddq = differentiate(q, log.rate_hz), differentiate_twice(q, log.rate_hz)
    load = loads(model, prepared)[:, list(axes)]
    if prepared.taken_off is not None:
        load = load - prepared.taken_off[:, list(axes)]
    drive = load - _beside_the_motor(model, prepared, axes)
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
                direction=prepared.raw_direction[:, axis],
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


def _beside_the_motor(model: RobotModel, prepared: Prepared, axes: Sequence[int]) -> Array:
    """(T, axes) torque of friction, offset and rotor that the model gives each axis; nothing of what holds at rest."""
    effects, none = model.equations.effects, np.zeros(prepared.log.samples)
    out = np.zeros((prepared.log.samples, len(axes)))
    for place, axis in enumerate(axes):
        signals = prepared.signals(axis, slice(None), none)
        for effect, coefficient in zip(effects, model.identified.xi[axis], strict=True):
            if effect.name != "motor_gain":
                out[:, place] += effect.column(signals) * coefficient
    return out


def loads(model: RobotModel, prepared: Prepared) -> Array:
    """(T, A) torque that body and outside forces ask of each axis, Y_j φ - F_j; computed once for each log."""
    return model.computed.of(prepared.log, "load", lambda: _loads(model, prepared))


def _loads(model: RobotModel, prepared: Prepared) -> Array:
    equations, axes = model.equations, model.equations.layout.axes
    phi_base, contacts = model.bodies_in(prepared.log.recording), ContactPaths(model.robot)
    load = equations.of_bodies(prepared.motion, phi_base)[:, axes]
    for start in range(0, len(load), CHUNK):
        which = slice(start, min(start + CHUNK, len(load)))
        load[which] -= contacts.effect(prepared.motion.q[which], prepared.wrenches[which])[:, axes]
    return load
