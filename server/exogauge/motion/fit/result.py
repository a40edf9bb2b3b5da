"""A person's motion as a body's: what a retargeter reads."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.motion.fit.body import TRUNK, HumanBody
from exogauge.robots.moving.segments import Segment

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class HumanFit:
    """time: (T,) [s]. q, q_sd: (T, K) [m, rad] in the order of `body.coordinates`, and their standard deviations.

    scale, scale_sd: by name. rotation: (T, 3, 3) R_world_part and position: (T, 3) [m] of the proximal joint, by
    segment; the pelvis' is the middle of the hips. end: (T, 3) [m] of hands' and feet's far ends.
    labels, offset: (M,), (M, 3) [m] where the points sit beside their nominal places, residual: (M,) [m] rms.
    noise: [m] sd of a coordinate of a point. lost: (T,) nothing is seen of pelvis or of thorax.
    told: what fits badly or is not known.
    """

    name: str
    body: HumanBody
    time: Array
    q: Array
    q_sd: Array
    scale: Mapping[str, float]
    scale_sd: Mapping[str, float]
    rotation: Mapping[Segment, Array]
    position: Mapping[Segment, Array]
    end: Mapping[Segment, Array]
    labels: tuple[str, ...]
    offset: Array
    residual: Array
    noise: float
    lost: NDArray[np.bool_]
    told: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        shape = (len(self.time), len(self.body.coordinates))
        assert self.q.shape == self.q_sd.shape == shape
        assert self.offset.shape == (len(self.labels), 3)

    @property
    def coordinates(self) -> Mapping[str, Array]:
        """(T,) [m, rad] by name; signs as `HumanBody` has them."""
        return {name: self.q[:, k] for k, name in enumerate(self.body.coordinates)}

    @property
    def trunk(self) -> Array:
        """(T, 3) [rad]: flexion, bend to the right, rotation to the left of the thorax in the pelvis."""
        first = self.body.index(TRUNK[0])
        return self.q[:, first : first + 3]

    @property
    def rms(self) -> float:
        """[m] of all points."""
        return float(np.sqrt(np.mean(self.residual**2)))
