"""What a force/torque sensor that carries bodies may do to its own reading."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Protocol, final

import numpy as np
from numpy.typing import NDArray

from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Shape

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


class SensorEffect(Protocol):
    """As `ShapedEffect`, for one component of one sensor. place is `sensor`.

    coordinate: of the evidence plot, `time` or `reading`.
    """

    name: ClassVar[str]
    place: ClassVar[str]
    sentence: ClassVar[str]
    coefficients: ClassVar[tuple[Quantity, ...]]
    shapes: ClassVar[tuple[Shape, ...]]
    confounds: ClassVar[tuple[str, ...]]
    needs: ClassVar[str]
    coordinate: ClassVar[str]

    def columns(self, signals: SensorSignals, shape: tuple[float, ...]) -> Array:
        """(T, C) what the component reads too much per unit of each coefficient."""
        ...

    def applies(self, signals: SensorSignals) -> bool:
        """Whether the log holds what the effect needs."""
        ...
