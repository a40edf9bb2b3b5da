"""What a force law is: the tension of a band from how its length changes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Protocol, final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Quantity:
    """A parameter of a law beside stiffness and natural length; with 0 the law is the linear one.

    sentence: what it is. low, high: its range, ends included. typical: of ordinary size, to begin with.
    """

    name: str
    unit: str
    sentence: str
    typical: float
    low: float = 0.0
    high: float = np.inf


@final
@dataclass(frozen=True)
class WireMotion:
    """T samples of one band of S segments, in the order of time.

    time: (T,) [s]. length: (T,) [m]. rate: (T,) [m/s]. For laws per segment, else None: segment_length: (T, S) [m],
    wrap: (T, S-1) [rad] by how much the band turns at each via point between its ends.
    """

    time: Array
    length: Array
    rate: Array
    segment_length: Array | None = None
    wrap: Array | None = None


class ForceLaw(Protocol):
    """One file each; `LAW` is the instance the catalogue finds.

    name: identifier, a contract with device.yaml. sentence: for the user. values: its own parameters, all needed.
    per_segment: the tension differs along the band.
    """

    name: ClassVar[str]
    sentence: ClassVar[str]
    values: ClassVar[tuple[Quantity, ...]]
    per_segment: ClassVar[bool]

    def tension(
        self, motion: WireMotion, stiffness: float, natural_length: float, values: Mapping[str, float]
    ) -> Array:
        """(T,), or (T, S) per segment, [N], not negative. stiffness [N/m], natural_length [m]. values: by name."""
        ...
