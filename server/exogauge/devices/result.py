"""What the identification of a device says."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal, final

import numpy as np
from numpy.typing import NDArray

from exogauge.remarks import Remark

Array = NDArray[np.float64]
Approach = Literal["A", "B", "paired", "prior"]


@final
@dataclass(frozen=True)
class Estimate:
    """A number with its standard deviation and unit. Where the data say nothing std is inf, and value NaN if any value
    would do.

    parts: source -> standard deviation that it alone makes; their squares add up to that of std. Sources: `scatter` of
    the logs, what the logs leave open of the `robot`, `null_test`, friction `at_rest`, or a declared uncertainty. Empty
    where nothing is told of it.
    """

    value: float
    std: float
    unit: str
    parts: Mapping[str, float] = field(default_factory=dict)


@final
@dataclass(frozen=True)
class BandEstimate:
    """One band by one approach. stiffness [N/m] (shared in its group), natural_length [m].

    stiffness_interval, natural_length_interval: (low, high), 95 %. true_stiffness, error_percent: None where no truth
    is known. identifiable, length_identifiable: the data decide it; note: why not, or None. with_effects: with
    what was named of the bands in the model, not as device.yaml states them alone. longest: [m] in these motions.
    """

    band: str
    group: str
    stiffness: Estimate
    natural_length: Estimate
    stiffness_interval: tuple[float, float]
    natural_length_interval: tuple[float, float]
    true_stiffness: float | None
    error_percent: float | None
    identifiable: bool
    length_identifiable: bool
    note: Remark | None
    with_effects: bool = False
    longest: float = math.nan


@final
@dataclass(frozen=True)
class CrossCheck:
    """Two numbers that ought to be one: the stiffness of a group [N/m] from each of two parts of the evidence.

    check: `approaches`, `repetitions`, `strokes`, `pulls`, `relaxation`, `sides` or `misfit`; of `halves` the two
    numbers are the natural length of a band [m] in the halves of a log; `repetitions` and `strokes` have such numbers
    [m] beside them, of one stiffness. between: names of the parts.
    difference: first minus second, std: of that, what both share taken off. limit: of z, beyond which they disagree, if
    the difference is more than `small`.
    misfit: by how much the stiffness may be off for what its springs leave, and its doubt.
    """

    check: str
    group: str
    between: tuple[str, str]
    difference: float
    std: float
    limit: float = math.inf
    unit: str = "N/m"
    small: float = 0.0

    @property
    def z(self) -> float:
        return self.difference / self.std

    @property
    def agrees(self) -> bool:
        return abs(self.z) <= self.limit or abs(self.difference) <= self.small


@final
@dataclass(frozen=True)
class NamedLaw:
    """What a search has named of a band or of a further wire, and its numbers beside the springs of this approach."""

    effect: str
    place: str
    numbers: Mapping[str, Estimate]


@final
@dataclass(frozen=True)
class StiffnessResult:
    """All bands of one device by one approach, from all its logs together.

    parameters: names `stiffness[group]`, `natural_length[band]` in the order of correlation (P, P).
    rms: [N·m] joint -> what the bands leave unexplained. samples: used. notes: what has to be kept in mind.
    named: what was fitted beside the springs.
    """

    device: str
    approach: Approach
    bands: tuple[BandEstimate, ...]
    parameters: tuple[str, ...]
    correlation: Array
    rms: Mapping[str, float]
    samples: int
    notes: tuple[Remark, ...]
    cross_checks: tuple[CrossCheck, ...] = ()
    named: tuple[NamedLaw, ...] = ()

    def with_nothing_decided(self) -> StiffnessResult:
        """The same, where no number counts as decided by the data."""
        bands = tuple(replace(each, identifiable=False, length_identifiable=False) for each in self.bands)
        return replace(self, bands=bands)
