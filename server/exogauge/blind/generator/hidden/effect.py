"""What a hidden effect is: torque that the motor gives, or seems to give, beyond the baseline.

Effects that are no joint's own: on links, on the base, in the force/torque sensor, in bands.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Protocol, Self, final

import numpy as np
from numpy.typing import NDArray

from exogauge.blind.generator.axis_run import AxisRun
from exogauge.blind.generator.scene import Scene

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


Where = Mapping[str, str | bool]


@final
@dataclass(frozen=True)
class Pull:
    """tension: (W, T) or, by stretches, (W, T, S) [N] that a band has beside k (l - l_0)."""

    band: str
    tension: Array


@final
@dataclass(frozen=True)
class Change:
    """torque: (L, T, J) [N·m] that joints must give beside all else. wrench: (L, T, 6) beside what the sensor says
    without it. None: nothing. on: (L, T) where it acts, None: everywhere. pull: where the torque is a band's,
    declared or not."""

    torque: Array | None
    wrench: Array | None
    on: NDArray[np.bool_] | None = None
    pull: Pull | None = None


class WholeEffect(Protocol):
    """A frozen dataclass whose fields are the drawn shape; how strong it is, its `size`, comes on top.

    name: identifier, as results.json has it. linear: the change is in proportion to size. reported: it changes what the
    sensor says, not what it feels.
    """

    name: ClassVar[str]
    linear: ClassVar[bool]
    reported: ClassVar[bool]

    @classmethod
    def places(cls, scene: Scene) -> list[Where]:
        """Where it could be, as results.json says it."""
        ...

    @classmethod
    def draw(cls, rng: np.random.Generator, scene: Scene, where: Where) -> Self:
        """A shape for this place."""
        ...

    def limits(self, scene: Scene) -> tuple[float, float]:
        """The smallest and the largest size that are hidden."""
        ...

    def believed(self, scene: Scene) -> float | None:
        """Where the size is the error of a number that is stated: its standard deviation by what is stated."""
        ...

    def change(self, scene: Scene, size: float) -> Change: ...
