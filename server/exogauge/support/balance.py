"""What a robot's model without a device leaves unexplained in a log: torque on the joints that someone else gives."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.disturbances import (
    ZERO,
    common_columns,
    drift_columns,
    zero_columns,
    zeros_in_doubt,
)
from exogauge.identification.equations import Equations
from exogauge.identification.model import RobotModel
from exogauge.identification.predict import Parameters, of_x
from exogauge.identification.preparation import Prepared
from exogauge.logs.model import Log
from exogauge.robots.description import drifts_in_doubt

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.intp]

FULL_REST = 0.9  # of the low-passed rest signal: above, an axis is at rest


@final
@dataclass(frozen=True)
class Balance:
    """T samples, D joints out of J, both sides low-passed alike.

    torque, torque_a_priori: (T, D) [N·m] Y_j φ - F_j - Z ξ without static friction, with the identified and with the
    maker's parameters: the supporting torque on the joint, up to what friction holds at rest.
    rest: (T, D) 0…1 share of that friction, largest of the axes that move the joint. steady: (T, D) all of them move
    at speed. sign: (T, A) directions of the axes. acts: (D, A) those that move each joint: two runs have the same
    friction where these go the same way.
    """

    prepared: Prepared
    joints: IntArray
    torque: Array
    torque_a_priori: Array
    rest: Array
    steady: BoolArray
    sign: NDArray[np.int8]
    acts: BoolArray

    @property
    def time(self) -> Array:
        return self.prepared.log.time

    @property
    def at_rest(self) -> BoolArray:
        return self.rest > FULL_REST

    @property
    def left_out(self) -> BoolArray:
        """(T,) something happened here that is not the robot's own (`Log.left_out`)."""
        return self.prepared.left_out


def balance(model: RobotModel, prepared: Prepared, joints: IntArray) -> Balance:
    """Both parameter sets on one log.

    Implements [Evaluator] (4), with (10)-(12) corrected. Differs from print: at rest static friction is left out, so
    that what is given there is the middle of an interval, not a number; rule (9) cannot know the device.
    """
    C = model.robot.axes_from_joints
    acts = (C[:, joints] != 0.0).T
    identified, a_priori = _on_axes(model.equations, prepared, [model.identified, model.a_priori])
    rest = np.stack([np.max(prepared.rest[:, axes], axis=1, initial=0.0) for axes in acts], axis=1)
    steady = np.stack([np.all(prepared.steady[:, axes], axis=1) for axes in acts], axis=1)
    sign = np.round(prepared.direction).astype(np.int8)
    return Balance(
        prepared,
        joints,
        identified @ C[:, joints],
        a_priori @ C[:, joints],
        np.clip(rest, 0.0, 1.0),
        steady,
        sign,
        acts,
    )


def prepare_worn(model: RobotModel, log: Log) -> Prepared:
    """A log with a wear, whose effects see what motor and gear still have to bear beside it.

    What the wear bears is what the whole model leaves unexplained, and that depends on what those effects see: found
    by half steps, which converge where an effect takes less than three times as much more as there is more to bear.
    """
    if model.extension is None:
        return model.prepare(log)
    bare = model.prepare_bare(log)
    borne = model.computed.of(log, "borne", lambda: _borne(model, log))
    return model.extension.attach(replace(bare, taken_off=borne))


def _borne(model: RobotModel, log: Log) -> Array:
    """(T, A) [N·m] what the wear bears of each axis' load."""
    half_steps = 8  # of what the wear bears
    assert model.extension is not None
    bare, prepared = model.prepare_bare(log), model.prepare(log)
    nothing = replace(prepared, added=np.zeros_like(prepared.added))
    (alone,) = _on_axes(model.equations, nothing, [model.identified])
    borne = np.zeros_like(alone)
    before: Array | None = None
    for _ in range(half_steps):
        left = alone - _added_on_axes(model.equations, prepared, model.identified)
        if before is not None and np.array_equal(left, before):  # nothing depends on what the wear bears
            break
        before = left
        borne = borne + 0.5 * (left - borne)
        prepared = model.extension.attach(replace(bare, taken_off=borne))
    return borne


def _added_on_axes(equations: Equations, prepared: Prepared, parameters: Parameters) -> Array:
    """(T, A) torque of the added columns."""
    out = np.zeros((prepared.log.samples, len(equations.robot.joints)))
    for axis, torque in enumerate(out.T):
        columns, entries = equations.added_to(equations.layout.axis(axis))
        torque += prepared.added[:, entries] @ parameters.added[columns]
    return out


def _on_axes(equations: Equations, prepared: Prepared, alternatives: Sequence[Parameters]) -> list[Array]:
    """(T, A) each."""
    axes = equations.layout.told.axes
    view = prepared.low_passed
    asked = equations.asked(prepared, view.signals(), view.added, of_x(equations, alternatives), axes)
    outside = equations.outside(prepared)[:, axes]
    return [each.T - outside for each in asked]


def slopes(model: RobotModel, prepared: Prepared, samples: IntArray, joints: IntArray) -> Iterator[tuple[int, Array]]:
    """(place in joints, (n, P + I) ∂torque/∂x at the chosen samples, and with the inputs that all logs share, which
    move x too), one joint after the other."""
    equations, C, view = model.equations, model.robot.axes_from_joints, prepared.low_passed
    blocks = equations.filled(prepared, samples, view.signals(samples), view.added)
    P, phi = equations.size, model.bodies_in(prepared.log.recording)
    direct = common_columns(equations, prepared, samples, model.cutoff_hz, phi)[:, :, equations.layout.told.axes] @ C
    for place, joint in enumerate(joints):
        slope = np.zeros((len(samples), P + len(model.inputs.names)))
        for axis in np.flatnonzero(C[:, joint]):
            kind = equations.layout.axis(int(axis))
            slope[:, equations.columns()[kind]] += C[axis, joint] * blocks[kind][:, :-1]
        if model.inputs.names:
            slope[:, P:] = slope[:, :P] @ model.inputs.moved + direct[:, :, joint]
        yield place, slope


def of_this_log(model: RobotModel, prepared: Prepared, samples: IntArray, joints: IntArray) -> dict[str, Array]:
    """Declared uncertainty -> (n, D, K) [N·m] what one standard deviation of each of its K inputs in this log makes of
    the torque: drifts of each motor, zero of each component of each contact sensor."""
    C, equations, sizes = model.robot.axes_from_joints, model.equations, drifts_in_doubt(model.robot)
    drifts = drift_columns(equations, model.identified.xi, prepared, samples)
    zeros = zero_columns(equations, prepared, samples)[:, :, equations.layout.axes] @ C[:, joints]
    size = zeros_in_doubt(model.robot)[: zeros.shape[1]]
    found = {name: (drifts[name] * size)[:, None, :] * C[:, joints].T for name, size in sizes.items()}
    return found | {ZERO: (zeros * size[:, None]).transpose(0, 2, 1)}
