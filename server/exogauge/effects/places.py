"""Places of a robot beside a single joint: two joints with one motor, an encoder, a sensor that carries bodies, a link
that carries a load, the base. Each has what an effect of it sees, and the protocol that its effects keep."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol, final

import numpy as np
from numpy.typing import NDArray

from exogauge.effects.shaped import AxisSignals, MissingEffect

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class PairSignals:
    """T samples of two actuator axes of a whole log. own: the axis further from the base. other: the next one before it
    that is driven."""

    own: AxisSignals
    other: AxisSignals

    @property
    def time(self) -> Array:
        """(T,) [s] from the log's start."""
        return self.own.time

    def motor_velocity(self, shape: tuple[float, ...]) -> Array:
        """(T,) [rad/s] of what turns with both, where the effect's first shape is their ratio."""
        return np.asarray(self.own.velocity + shape[0] * self.other.velocity)


class PairEffect(MissingEffect, Protocol):
    """place is `pair`; it is told of the joint further from the base. coordinate: `motor_velocity` or `time`."""

    def columns(self, signals: PairSignals, shape: tuple[float, ...]) -> Array:
        """(T, C, 2) torque delivered to the own and to the other axis per unit of each coefficient, friction negative;
        not low-passed, as that of `ShapedEffect`."""
        ...

    def applies(self, signals: PairSignals) -> bool:
        """Whether the log holds what the effect needs."""
        ...


@final
@dataclass(frozen=True)
class EncoderSignals:
    """T samples of what one joint's encoder has read. time: (T,) [s] from the log's start. position: (T,) [rad].

    first: nothing before the joint moves, so that a constant error of it turns the robot as a whole."""

    time: Array
    position: Array
    first: bool = False


class EncoderEffect(MissingEffect, Protocol):
    """Of the angle that a joint's encoder reads, which every row feels. place is `encoder`; it is told of the joint.
    coordinate: `position` or `time`."""

    def errors(self, signals: EncoderSignals, shape: tuple[float, ...]) -> Array:
        """(T, C) by how much the true angle is more than the one that was read, per unit of each coefficient. What
        changes makes the joint faster, too, and accelerates it."""
        ...

    def applies(self, signals: EncoderSignals) -> bool:
        """Whether the log holds what the effect needs."""
        ...


@final
@dataclass(frozen=True)
class SensorSignals:
    """T samples of one component (0..5, forces before moments) of one sensor, or of all of them (-1).

    time: (T,) [s] from the log's start. expected: (T, 6) what the model's bodies make it read [N, N·m], in the log's
    sign, without its zero; not the measured reading, whose noise would explain itself. number: of the log in the order
    of the study, from 0; -1 where it is not known. contacts: how many sensors there are of this one's kind whose
    wrench is taken for known, under a foot say: no body explains it, its zero is in no model, and expected is what it
    has read. 0: bodies explain it.
    """

    time: Array
    expected: Array
    component: int
    number: int = -1
    contacts: int = 0

    @property
    def reading(self) -> Array:
        """(T,) expected of this component."""
        return np.asarray(self.expected[:, self.component])


class SensorEffect(MissingEffect, Protocol):
    """Of one component of a sensor that carries bodies. place is `sensor`; coordinate: `time` or `reading`."""

    def columns(self, signals: SensorSignals, shape: tuple[float, ...]) -> Array:
        """(T, C) what the component reads too much per unit of each coefficient."""
        ...

    def applies(self, signals: SensorSignals) -> bool:
        """Whether the log holds what the effect needs."""
        ...


class WholeSensorEffect(MissingEffect, Protocol):
    """Of a sensor with all its components. place is `whole_sensor`; coordinate: `time`."""

    def columns(self, signals: SensorSignals, shape: tuple[float, ...]) -> Array:
        """(T, C, 6) what each component reads too much per unit of each coefficient."""
        ...

    def applies(self, signals: SensorSignals) -> bool:
        """Whether the log holds what the effect needs."""
        ...


@final
@dataclass(frozen=True)
class LinkSignals:
    """One link in one log of T samples. time: (T,) [s]. number: of the log in the order of the study, from 0; -1 where
    it is not known. carries_nothing: no link hangs on it: a hand, a tool."""

    time: Array
    number: int
    carries_nothing: bool


class LinkEffect(MissingEffect, Protocol):
    """Of the mass and the first moments of a link. place is `link`; coordinate: `time`."""

    def present(self, signals: LinkSignals, shape: tuple[float, ...]) -> float:
        """1 in a log that has it, else 0. Coefficients: mass [kg], then first moments [kg·m] in the link's frame."""
        ...

    def applies(self, signals: LinkSignals) -> bool:
        """Whether it can sit there."""
        ...


@final
@dataclass(frozen=True)
class BaseSignals:
    """T samples of the base link, in its frame: (T, 3) proper acceleration [m/s²], angular velocity [rad/s] and
    acceleration [rad/s²], and their rates. time: (T,) [s]. floating: measured by an IMU; else it stands still.
    first_angle: (T,) [rad] of the first joint. imu_at: (3,) [m] where the IMU is. feet_feel: every contact sensor
    measures forces and moments along all axes (what nobody measured is logged as a constant). turn: (3,) [rad] rotation
    vector by which the base was found to be turned so far; zero before."""

    time: Array
    acc: Array
    gyro: Array
    gyro_dot: Array
    acc_rate: Array
    gyro_rate: Array
    gyro_dot_rate: Array
    floating: bool
    first_angle: Array
    imu_at: Array = field(default_factory=lambda: np.zeros(3))
    feet_feel: bool = False
    turn: Array = field(default_factory=lambda: np.zeros(3))


@final
@dataclass(frozen=True)
class BaseChange:
    """(T, 3) each: how the base's motion differs per unit of a coefficient.

    first_torque: (T,) [N·m] what the first joint has to give beside that.
    """

    acc: Array
    gyro: Array
    gyro_dot: Array
    first_torque: Array | None = None


class BaseEffect(MissingEffect, Protocol):
    """Of the base. place is `base`; coordinate: `time`."""

    def changes(self, signals: BaseSignals, shape: tuple[float, ...]) -> list[BaseChange]:
        """One for each coefficient: the true motion is the stated one plus these."""
        ...

    def applies(self, signals: BaseSignals) -> bool:
        """Whether the log holds what the effect needs."""
        ...
