"""What the identification of a device says."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Approach = Literal["A", "B", "prior"]


@final
@dataclass(frozen=True)
class Estimate:
    """A number with its standard deviation and unit. Where the data say nothing std is inf, and value NaN if any value
    would do."""

    value: float
    std: float
    unit: str


@final
@dataclass(frozen=True)
class BandEstimate:
    """One band by one approach. stiffness [N/m] (shared in its group), natural_length [m].

    stiffness_interval, natural_length_interval: (low, high), 95 %.
    true_stiffness, error_percent: None where no truth is known. identifiable, length_identifiable: the data decide it;
    note: in words, why not, or "". with_effects: with what was named of the bands in the model, not as device.yaml
    states them alone. longest: [m] in these motions.
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
    note: str
    with_effects: bool = False
    longest: float = math.nan


@final
@dataclass(frozen=True)
class StiffnessResult:
    """All bands of one device by one approach, from all its logs together.

    parameters: names `stiffness[group]`, `natural_length[band]` in the order of correlation (P, P).
    rms: [N·m] joint -> what the bands leave unexplained. samples: used. notes: sentences for the user.
    """

    device: str
    approach: Approach
    bands: tuple[BandEstimate, ...]
    parameters: tuple[str, ...]
    correlation: Array
    rms: Mapping[str, float]
    samples: int
    notes: tuple[str, ...]
