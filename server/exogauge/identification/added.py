"""Effects that the model gets beside its own: on one axis each, with their shapes chosen before."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import AxisSignals, ShapedEffect
from exogauge.identification.contacts import ContactPaths
from exogauge.identification.model import RobotModel
from exogauge.identification.preparation import WIDEST, Prepared
from exogauge.logs.derivatives import differentiate, differentiate_twice
from exogauge.logs.filtering import LowPass

Array = NDArray[np.float64]

CHUNK = 2000


@final
@dataclass(frozen=True)
class AddedEffect:
    """effect on actuator axis `axis` with the values of its shapes."""

    effect: ShapedEffect
    axis: int
    shape: tuple[float, ...] = ()


@final
@dataclass(frozen=True)
class AddedColumn:
    """One coefficient of an added effect. name: `stribeck.tau_b`; axis: whose rows it is in."""

    name: str
    axis: int
    coefficient: Quantity


@final
@dataclass(frozen=True)
class Extension:
    """parent: the model that the effects are added to; its loads and motor torques are what they see.

    noise_floors: (log, channel) -> what was found with the parent; sensors' noise does not change with the model.
    """

    parent: RobotModel
    effects: tuple[AddedEffect, ...]
    noise_floors: Mapping[tuple[str, str], float] = field(default_factory=dict)

    @property
    def columns(self) -> tuple[AddedColumn, ...]:
        """In the order of x."""
        return tuple(
            AddedColumn(f"{each.effect.name}.{coefficient.name}", each.axis, coefficient)
            for each in self.effects
            for coefficient in each.effect.coefficients
        )

    def attach(self, prepared: Prepared) -> Prepared:
        """The same log with the torques of the added effects per unit of their coefficients, filtered as the drive."""
        signals: dict[int, AxisSignals] = {}
        raw = []
        for each in self.effects:
            if each.axis not in signals:
                signals[each.axis] = axis_signals(self.parent, prepared, [each.axis])[0]
            raw.append(each.effect.columns(signals[each.axis], each.shape))
        stacked = np.hstack(raw) if raw else np.zeros((prepared.log.samples, 0))
        before = prepared.low_pass.before
        stored = before.apply(stacked) if before else stacked
        return replace(prepared, added=prepared.low_pass.apply(stacked), raw_added=stored)


def axis_signals(model: RobotModel, prepared: Prepared, axes: Sequence[int]) -> list[AxisSignals]:
    """What shaped effects see of some axes of a log, at the bandwidth that its encoders can bear."""
    robot, log, C = model.robot, prepared.log, model.robot.axes_from_joints
    finest = LowPass(min(model.at_rest.cutoff_hz, WIDEST * log.rate_hz), log.rate_hz)
    q = finest.apply(log.stack([f"q.{joint.name}" for joint in robot.joints])) @ C.T[:, list(axes)]
    dq, ddq = differentiate(q, log.rate_hz), differentiate_twice(q, log.rate_hz)
    load = loads(model, prepared)[:, list(axes)]
    drive = load - _beside_the_motor(model, prepared, axes)
    result = []
    for place, axis in enumerate(axes):
        temperature = log.channels.get(f"temp.{robot.joints[axis].name}")
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
    known = model.load_of_log.get(prepared.log.name)
    if known is not None and len(known) == prepared.log.samples:
        return known
    equations, first = model.equations, model.equations.first_axis
    phi_base, contacts = equations.base.regroup @ model.identified.phi.ravel(), ContactPaths(model.robot)
    load = np.empty((prepared.log.samples, len(model.robot.joints)))
    for start in range(0, len(load), CHUNK):
        which = slice(start, min(start + CHUNK, len(load)))
        motion = prepared.motion.rows(which)
        external = contacts.effect(motion.q, prepared.wrenches[which])
        load[which] = (equations.blocks.predict(motion, phi_base) - external)[:, first:]
    model.load_of_log[prepared.log.name] = load
    return load
