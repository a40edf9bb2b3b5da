"""A weighed load that is fixed to a link in some logs: what is stated of it, as ten inertial parameters with doubts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.robots.parameters import inertia_by_first_moment

Array = NDArray[np.float64]

GYRATION_M = 0.1  # radius of gyration that hardly any load on an arm exceeds: a disc of 28 cm has it


@final
@dataclass(frozen=True)
class KnownLoad:
    """name: its link, with a number where that carries several. body: of the tree, what the link is a part of.

    mass, std: [kg]. centre: (3,) [m] of mass, in the body's frame; std_centre: [m], alike in all directions.
    logs: names of the recordings that carry it.
    """

    name: str
    body: int
    mass: float
    std: float
    centre: tuple[float, float, float]
    std_centre: float
    logs: tuple[str, ...]

    @property
    def columns(self) -> Array:
        """(10, 10) inertial parameters of the body (as `RigidTree.phi`) per coefficient.

        A mass at the stated centre; a first moment beside it, which takes its inertia along; inertia about the centre.
        """
        c, apart = np.array(self.centre), inertia_by_first_moment(np.array(self.centre))
        columns = np.eye(10)
        columns[1:4, 0], columns[4:, 0] = c, 0.5 * apart @ c
        columns[4:, 1:4] = apart
        return columns

    @property
    def mean(self) -> Array:
        """(10,) of the coefficients."""
        return np.array([self.mass, *np.zeros(9)])

    @property
    def doubt(self) -> Array:
        """(10,) standard deviations of the coefficients. Inertia was not stated: how wide the load is, and the square
        of how far its centre may be off; half of that off the diagonal."""
        inertia = self.mass * (GYRATION_M**2 + self.std_centre**2)
        return np.array([self.std, *[self.mass * self.std_centre] * 3, *inertia * np.array([1, 0.5, 1, 0.5, 0.5, 1])])

    @property
    def phi(self) -> Array:
        """(10,) as stated, of the body it is fixed to."""
        return np.asarray(self.columns @ self.mean)
