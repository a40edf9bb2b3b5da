"""What every solver returns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Estimate:
    """An answer with its doubt.

    value: (P,). covariance: (P, P). rms: weighted residual rms (1 when the weights fit the noise).
    condition: of the column-scaled information. rank: number of directions that the data determine.
    """

    value: Array
    covariance: Array
    rms: float
    condition: float
    rank: int
    warnings: tuple[str, ...] = ()

    @property
    def std(self) -> Array:
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))
