"""What a force/torque sensor that carries bodies may do to its own reading."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, final

import numpy as np
from numpy.typing import NDArray

from exogauge.effects.shaped import MissingEffect

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class SensorSignals:
    """T samples of one component (0..5, forces before moments) of one sensor.

    time: (T,) [s] from the log's start. expected: (T, 6) what the model's bodies make it read [N, N·m], in the log's
    sign, without its zero; not the measured reading, whose noise would explain itself. number: of the log in the order
    of the study, from 0; -1 where it is not known.
    """

    time: Array
    expected: Array
    component: int
    number: int = -1

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
