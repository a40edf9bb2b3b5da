"""What a hidden effect is: torque that the motor gives, or seems to give, beyond the baseline."""

from __future__ import annotations

from typing import ClassVar, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from exogauge.blind.generator.axis_run import AxisRun

Array = NDArray[np.float64]


class HiddenEffect(Protocol):
    """A frozen dataclass whose fields are the drawn shape; how strong it is, its `size`, comes on top.

    name: identifier, as results.json has it. linear: the torque is in proportion to size. reported: it acts on what the
    log says of the motor's torque, after all others.
    """

    name: ClassVar[str]
    linear: ClassVar[bool]
    reported: ClassVar[bool]

    @classmethod
    def draw(cls, rng: np.random.Generator, run: AxisRun) -> Self:
        """A shape for this joint."""
        ...

    def largest(self, run: AxisRun) -> float:
        """The size beyond which nobody would believe it."""
        ...

    def torque(self, run: AxisRun, size: float) -> Array:
        """(L, T) [N·m] to add to the motor's torque k_T i; run.motor is what it is without this effect."""
        ...
