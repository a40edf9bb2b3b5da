"""Where the sensor's axes may point."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Cap:
    """Where one axis of {S} may point in {B}: θ [rad] from +z of {B}, in [0, π]; φ [rad] about it, φ[0] to φ[1].

    axis: 0, 1, 2 for x, y, z. A range of φ of a whole turn or more bounds nothing; one may pass ±π.
    """

    axis: int
    phi: tuple[float, float] = (-np.pi, np.pi)
    theta: tuple[float, float] = (0.0, np.pi)

    def margins(self, direction: Array) -> tuple[Array, Array]:
        """(T, C) not negative where allowed, and (T, C, 3) their slopes by the direction (T, 3).

        Implements [Payload] (36). Differs from print: the axes are the columns of R_BS, not its rows. φ = atan2(y, x)
        jumps at ±π, so that its range is told by the angle from its middle.
        """
        pole = 1e-9  # of a unit vector, squared: within it of a pole φ is not defined, and bounds nothing
        x, y, z = direction.T
        found, slopes = [], []
        for bound, side in ((self.theta[0], -1.0), (self.theta[1], 1.0)):
            if 0.0 < bound < np.pi:
                found.append(side * (z - np.cos(bound)))
                slopes.append(np.tile([0.0, 0.0, side], (len(z), 1)))
        middle, half = (self.phi[0] + self.phi[1]) / 2, (self.phi[1] - self.phi[0]) / 2
        if half < np.pi:
            level = np.sqrt(x**2 + y**2 + pole)
            found.append(x * np.cos(middle) + y * np.sin(middle) - np.cos(half) * (level - np.sqrt(pole)))
            slopes.append(
                np.column_stack([
                    np.cos(middle) - np.cos(half) * x / level, np.sin(middle) - np.cos(half) * y / level, 0.0 * z,
                ])
            )  # fmt: skip
        if not found:
            return np.zeros((len(z), 0)), np.zeros((len(z), 0, 3))
        return np.stack(found, axis=1), np.stack(slopes, axis=1)


def inside(caps: Sequence[Cap], rotation: Array) -> NDArray[np.bool_]:
    """(T,) whether the axes of R_BS (T, 3, 3) point where they may."""
    allowed = np.ones(len(rotation), dtype=bool)
    for cap in caps:
        allowed &= (cap.margins(rotation[:, :, cap.axis])[0] >= -1e-12).all(axis=1)
    return allowed
