"""Where an effect can sit, and what it does to the equations from there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, final

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from exogauge.effects.base import BaseChange, BaseSignals
from exogauge.effects.scales import in_si
from exogauge.effects.sensor import SensorSignals
from exogauge.effects.shaped import AxisSignals, ManyShapes, MissingEffect
from exogauge.identification.axis_signals import axis_signals
from exogauge.identification.equations import Equations
from exogauge.identification.preparation import Prepared
from exogauge.identification.sensor_zero import COMPONENTS
from exogauge.logs.derivatives import differentiate
from exogauge.robots.motion import Motion
from exogauge.robots.parameters import of_slide
from exogauge.robots.rows import RowType

if TYPE_CHECKING:
    from exogauge.identification.model import RobotModel

Array = NDArray[np.float64]

STEP = 1e-3  # of a coefficient, for the slope of the equations with it
PER_PERIOD = 6  # samples in a period of the cut-off frequency, at which a response is computed


class Effect(MissingEffect, Protocol):
    """Of any place: `columns`, `changes` or `present` is for its site to call."""

    def applies(self, signals: Any) -> bool: ...


@final
@dataclass(frozen=True)
class Seen:
    """What a site sees of one log. signals: what its effects take.

    columns: (effect, shape) -> (T, C, kinds) what each coefficient takes off the rows of each of the site's kinds, per
    unit, not low-passed.
    """

    signals: Any
    columns: Callable[[Any, tuple[float, ...]], Array]

    def channels(self, effect: Any, shapes: Sequence[tuple[float, ...]]) -> Array:
        """(L C kinds, T) the columns of several shapes, one after the other."""
        if isinstance(effect, ManyShapes) and isinstance(self.signals, AxisSignals):
            return effect.columns_of_all(self.signals, shapes)
        every = [self.columns(effect, shape) for shape in shapes]
        return np.concatenate([each.reshape(len(each), -1).T for each in every])

    def coordinate(self, name: str, shape: tuple[float, ...] = ()) -> Array:
        """(T,) of the evidence plot, which may depend on the shape; time where the log does not hold it."""
        values = getattr(self.signals, name, None)
        values = values(shape) if callable(values) else values
        return np.asarray(values if values is not None else self.signals.time)


class Site(Protocol):
    """label: (`joint` | `sensor` | `base`, name, part of it or "")."""

    def label(self, equations: Equations) -> tuple[str, str, str]: ...

    def kinds(self, equations: Equations) -> tuple[int, ...]: ...

    def see(self, model: RobotModel, prepared: Prepared) -> Seen: ...

    def in_si(self, model: RobotModel, unit: str, shape: tuple[float, ...]) -> tuple[float, str]: ...


@final
@dataclass(frozen=True)
class AxisSite:
    """An actuator axis."""

    axis: int

    def label(self, equations: Equations) -> tuple[str, str, str]:
        return "joint", equations.robot.joints[self.axis].name, ""

    def kinds(self, equations: Equations) -> tuple[int, ...]:
        return (equations.layout.axis(self.axis),)

    def see(self, model: RobotModel, prepared: Prepared) -> Seen:
        signals = axis_signals(model, prepared, [self.axis])[0]
        return seen_of_axis(signals)

    def in_si(self, model: RobotModel, unit: str, shape: tuple[float, ...]) -> tuple[float, str]:
        sizes = (model.sizes.velocity, model.sizes.torque, model.sizes.range)
        factor, own = in_si(unit, *(float(each[self.axis]) for each in sizes))
        return factor, of_slide(own) if model.robot.joints[self.axis].name in model.robot.tree.sliding else own


def seen_of_axis(signals: AxisSignals) -> Seen:
    return Seen(signals, lambda effect, shape: effect.columns(signals, shape)[:, :, None])


@final
@dataclass(frozen=True)
class SensorSite:
    """One component (0..5) of a sensor that carries bodies; sensor: among `Robot.cuts`."""

    sensor: int
    component: int

    def label(self, equations: Equations) -> tuple[str, str, str]:
        return "sensor", equations.robot.cuts[self.sensor].name, COMPONENTS[self.component]

    def kinds(self, equations: Equations) -> tuple[int, ...]:
        return tuple(equations.layout.sensor(self.sensor))  # what one does moves the bodies, and with them all six

    def see(self, model: RobotModel, prepared: Prepared) -> Seen:
        sign = model.robot.cuts[self.sensor].sign
        expected = -sign * carried(model, prepared)[:, 6 * self.sensor : 6 * self.sensor + 6]
        number = model.order.get(prepared.log.name, -1)
        signals = SensorSignals(prepared.log.time - prepared.log.time[0], expected, self.component, number)

        def columns(effect: Any, shape: tuple[float, ...]) -> Array:
            own = sign * effect.columns(signals, shape)
            every = np.zeros((*own.shape, 6))
            every[:, :, self.component] = own
            return every

        return Seen(signals, columns)

    def in_si(self, model: RobotModel, unit: str, shape: tuple[float, ...]) -> tuple[float, str]:
        own = "N" if self.component < 3 else "N·m"
        if unit == "reading/reading":
            other = "N" if round(shape[0]) < 3 else "N·m"
            return 1.0, {("N", "N"): "1", ("N·m", "N·m"): "1", ("N·m", "N"): "m", ("N", "N·m"): "1/m"}[own, other]
        return 1.0, unit.replace("reading", own)


@final
@dataclass(frozen=True)
class BaseSite:
    """The base: every row feels how it stands and moves."""

    def label(self, equations: Equations) -> tuple[str, str, str]:
        return "base", "base", ""

    def kinds(self, equations: Equations) -> tuple[int, ...]:
        layout, joints = equations.layout, enumerate(equations.robot.joints)
        axes = [layout.axis(axis) for axis, joint in joints if joint.actuation != "none"]
        return (*layout.numbers(RowType.BASE), *axes, *layout.numbers(RowType.SENSOR))

    def see(self, model: RobotModel, prepared: Prepared) -> Seen:
        motion, rate = prepared.motion, prepared.log.rate_hz
        acc, gyro, gyro_dot = (differentiate(each, rate) for each in (motion.acc, motion.gyro, motion.gyro_dot))
        time = prepared.log.time - prepared.log.time[0]
        still = (motion.acc, motion.gyro, motion.gyro_dot)
        imu, feet = model.robot.T_base_imu, prepared.raw_wrenches
        place = np.zeros(3) if imu is None else imu.translation
        feel = bool(feet.size) and bool(np.all(np.ptp(feet, axis=0) > 0.0))
        floating = model.robot.floating
        signals = BaseSignals(time, *still, acc, gyro, gyro_dot, floating, motion.q[:, 0], place, feel)
        layout = model.equations.layout
        own = layout.in_told(self.kinds(model.equations))

        def columns(effect: Any, shape: tuple[float, ...]) -> Array:
            changes: Sequence[BaseChange] = effect.changes(signals, shape)
            rows = [_response(model, prepared, change) for change in changes]
            for each, change in zip(rows, changes, strict=True):
                if change.first_torque is not None:
                    each[:, layout.told.axis(0)] -= change.first_torque
            return np.stack([each[:, own] for each in rows], axis=1)

        return Seen(signals, columns)

    def in_si(self, model: RobotModel, unit: str, shape: tuple[float, ...]) -> tuple[float, str]:
        return 1.0, unit


def carried(model: RobotModel, prepared: Prepared) -> Array:
    """(T, 6 C) what holds and moves the bodies beyond each sensor, in its frame, without its zero."""
    return model.computed.of(
        prepared.log,
        "carried",
        lambda: model.equations.of_carried(prepared.motion, model.bodies_in(prepared.log.recording)),
    )


def _response(model: RobotModel, prepared: Prepared, change: BaseChange) -> Array:
    """(T, told rows) what the change takes off each per unit: - d(Y φ)/dθ.

    Computed at some of the samples, with a cubic spline between: whatever moves, moves below the cut-off.
    """
    samples, phi = prepared.motion.samples, model.bodies_in(prepared.log.recording)
    if not change.acc.any() and change.first_torque is not None:
        return np.zeros((samples, len(model.equations.layout.told)))
    stride = max(1, int(prepared.log.rate_hz / (PER_PERIOD * model.cutoff_hz)))
    at = np.unique(np.append(np.arange(0, samples, stride), samples - 1))
    m = prepared.motion.rows(at)
    acc, gyro, gyro_dot = (each[at] for each in (change.acc, change.gyro, change.gyro_dot))

    def moved(step: float) -> Array:
        base = m.acc + step * acc, m.gyro + step * gyro, m.gyro_dot + step * gyro_dot
        return model.equations.of_told(Motion(m.q, m.dq, m.ddq, *base), phi)

    if not gyro.any() and not gyro_dot.any():  # then the rows are linear in it
        still = np.zeros_like(m.q)
        response = -model.equations.of_told(Motion(m.q, still, still, acc, gyro, gyro_dot), phi)
    else:
        response = (moved(-STEP) - moved(STEP)) / (2.0 * STEP)
    return response if stride == 1 else np.asarray(CubicSpline(at, response)(np.arange(samples)))
