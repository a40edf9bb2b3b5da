"""What may be missing beside a rigid body behind an ideal sensor: the columns that it adds to the rows of a stretch."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from exogauge.payload.missing.stretch import Stretch
from exogauge.payload.statics import upright

Array = NDArray[np.float64]

CHANNELS = ("fx", "fy", "fz", "mx", "my", "mz")
UNITS = ("N",) * 3 + ("N·m",) * 3


@final
@dataclass(frozen=True)
class Frame:
    """What columns are made with. gravity: (3,) [m/s²] in {B}. sign: s. body: (10,) [m, m c, I] as known so far."""

    gravity: Array
    sign: int
    body: Array

    def tilting(self, stretch: Stretch) -> Array:
        """(T, 6, 2) of a turn of gravity by 1 rad about two axes across it: x and y of a base that stands."""
        turned = np.cross(upright(self.gravity)[:2], self.gravity).T
        tipped = -np.swapaxes(stretch.motion.rotation, 1, 2) @ turned
        return np.concatenate(
            [self.sign * self.body[0] * tipped, self.sign * pin.skew(self.body[1:4]) @ tipped], axis=1
        )


Columns = Callable[[Frame, Stretch, Sequence[float]], Array]
Told = Callable[[Frame, Array, Array], Array]


@final
@dataclass(frozen=True)
class Effect:
    """columns: (T, 6, P) by its shapes, what does not enter linearly. parameters: (name, unit) of what is told; told:
    those numbers, of shapes and coefficients (P,). bounds, starts: of the shapes. of_log: the one log that it is about.
    retimed: its one shape is how late the wrench is [s], and it adds no column. unit: its column's coefficient is 1.
    jumps: its one shape is a moment [s]. swings: it answers to accelerations, as errors of the kinematics do.
    possible: whether such a thing can be, by what is told.
    """

    name: str
    place: str
    parameters: tuple[tuple[str, str], ...]
    columns: Columns
    told: Told
    bounds: tuple[tuple[float, float], ...] = ()
    starts: tuple[tuple[float, ...], ...] = ((),)
    of_log: str | None = None
    retimed: bool = False
    unit: bool = False
    jumps: bool = False
    swings: bool = False
    possible: Callable[[Array], bool] = lambda _told: True

    @property
    def coefficients(self) -> int:
        return 0 if self.unit else len(self.parameters) - len(self.bounds)

    @property
    def fitted(self) -> int:
        """How many numbers are chosen by the data."""
        return self.coefficients + len(self.bounds)
