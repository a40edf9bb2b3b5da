"""What acts on two neighbouring axes at once, because something turns with both."""

from __future__ import annotations

from dataclasses import dataclass
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
