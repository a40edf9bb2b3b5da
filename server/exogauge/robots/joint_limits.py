"""What the joints of a robot must not exceed when a motion is planned for it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class JointLimits:
    """(J,) each, in the order of the joints [rad or m and their rates; N·m or N]; inf where there is none."""

    lower: Array
    upper: Array
    velocity: Array
    acceleration: Array
    torque: Array
    jerk: Array | None = None  # None: of no joint
