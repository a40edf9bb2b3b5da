"""What an effect that is not in the model could be: columns that enter linearly, with shapes that do not.

Shapes are searched in sizes of the axis' own motion; a user reads them in SI. What only some effects say of themselves
is asked by a function: yes where the file of the effect sets it to True, else no.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, final, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from exogauge.effects.effect import Quantity

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Shape:
    """A value that enters non-linearly: tried at `grid`, refined between low and high unless it is a choice. words:
    what it is."""

    name: str
    unit: str
    low: float
    high: float
    grid: tuple[float, ...] = ()
    choice: bool = False
    words: str = ""

    @property
    def of_two(self) -> bool:
        """One of its ends or the other, and nothing between."""
        return self.grid == (self.low, self.high)

    def share(self, value: float) -> float:
        """0…1 between the bounds; in logarithms where both are positive."""
        if self.low > 0.0:
            return float(np.log(value / self.low) / np.log(self.high / self.low))
        return (value - self.low) / (self.high - self.low)

    def at(self, share: float) -> float:
        """The value that has this `share`."""
        if self.low > 0.0:
            return float(self.low * (self.high / self.low) ** share)
        return float(self.low + share * (self.high - self.low))


@final
@dataclass(frozen=True)
class AxisSignals:
    """T samples of one actuator axis of a whole log, at the bandwidth that its encoder can bear.

    time: (T,) [s] from the log's start. position [rad], velocity [rad/s], acceleration [rad/s²]. direction: sign of the
    velocity, 0 at rest. load: (T,) torque that the model's body and outside forces ask of the joint, Y_j φ - F_j [N·m].
    drive: (T,) torque that the model calls for from the motor [N·m]; not the measured one, whose noise is in the
    residual too and would explain itself. temperature: (T,) [°C] or None where it is not logged.
    speed_scale, torque_scale, range: of the axis over all fitted logs: rms velocity, rms torque and range of
    position, for scale-free shapes; the same in every log.
    number: of the log in the order of the study, from 0; -1 where it is not known.
    inertia: (T,) [kg·m²] of what the axis turns; slope: (T,) [N·m/rad] of the load over its angle, by gravity;
    usual_inertia: mean of the fitted logs. None: not known, and taken for constant.
    """

    time: Array
    position: Array
    velocity: Array
    acceleration: Array
    direction: Array
    drive: Array
    load: Array
    temperature: Array | None
    speed_scale: float
    torque_scale: float
    range: float
    number: int = -1
    inertia: Array | None = None
    slope: Array | None = None
    usual_inertia: float = 1.0


class MissingEffect(Protocol):
    """A reason why a measurement is not what the model says. One file each; `EFFECT` is what the catalogue finds.

    name: identifier, a contract with results.json. words: the name that a person reads, within a sentence. place: where
    it can sit: `joint`, `pair` (of joints), `sensor`, `link` or `base`. sentence: for the user. coefficients: what is
    estimated linearly. shapes: what is searched. confounds: what of the baseline can stand in for it. needs: in words,
    the motion that shows it. coordinate: of the evidence plot.

    What only some have is in `flags`; `departing` with `departures`, how the real thing departs from the formula, in
    `own_curve`.
    """

    @property
    def name(self) -> str: ...

    @property
    def words(self) -> str: ...

    @property
    def place(self) -> str: ...

    @property
    def sentence(self) -> str: ...

    @property
    def coefficients(self) -> tuple[Quantity, ...]: ...

    @property
    def shapes(self) -> tuple[Shape, ...]: ...

    @property
    def confounds(self) -> tuple[str, ...]: ...

    @property
    def needs(self) -> str: ...

    @property
    def coordinate(self) -> str: ...


class ShapedEffect(MissingEffect, Protocol):
    """Of a joint. coordinate: one of `velocity`, `position`, `load`, `time`, `acceleration`, `drive`, `temperature`."""

    def columns(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        """(T, C) torque delivered to the joint per unit of each coefficient, friction negative. Not low-passed: who
        calls passes each column through the filter that the drive has passed."""
        ...

    def applies(self, signals: AxisSignals) -> bool:
        """Whether the log holds what the effect needs (a temperature, motion, load …)."""
        ...


@runtime_checkable
class ManyShapes(Protocol):
    """An effect of a joint that computes several shapes at once in less time than one by one."""

    def columns_of_all(self, signals: AxisSignals, shapes: Sequence[tuple[float, ...]]) -> Array:
        """(L C, T) what `columns` gives for each of L shapes, one column after the other."""
        ...


def along_motion(effect: object) -> bool:
    """Evidence is shown along the motion, what opposes it being negative: friction over anything but velocity would
    cancel in a mean over both directions."""
    return bool(getattr(effect, "along_motion", False))


def at_turns(effect: object) -> bool:
    """It shows where a joint turns round, as a low-pass does that is not quite the model's: it is not looked for where
    every log was low-passed before it was stored."""
    return bool(getattr(effect, "at_turns", False))


def common_cause(effect: object) -> bool:
    """Places have it in common (one bus, one filter, one amplifier that warms up): on most of them it is told once."""
    return bool(getattr(effect, "common_cause", False))


def of_logged_torque(effect: object) -> bool:
    """It is a factor of the logged torque: where currents are logged, the model's own k_T is that factor."""
    return bool(getattr(effect, "of_logged_torque", False))


OWN_SIZES = ("rms velocity", "rms torque", "range", "cycles per range")


def in_si(unit: str, speed_scale: float, torque_scale: float, span: float) -> tuple[float, str]:
    """What a value in this unit of a shape is multiplied by on an axis, and the unit it then has.

    speed_scale, torque_scale, span: the axis' rms velocity [rad/s], rms torque [N·m] and range [rad] (`AxisSignals`).
    Other units than `OWN_SIZES` stay as they are.
    """
    sizes = {
        "rms velocity": (speed_scale, "rad/s"),
        "rms torque": (torque_scale, "N·m"),
        "range": (span, "rad"),
        "cycles per range": (2.0 * math.pi / span if span else 0.0, "1/rev"),
    }
    return sizes.get(unit, (1.0, unit))
