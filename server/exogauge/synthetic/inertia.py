"""Mass, centre and second moments of the primitive shapes, and the ten numbers of a body about its frame's origin."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.synthetic.robot_facts import Link

Array = NDArray[np.float64]

PHI_NAMES = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")
_SPREAD = {  # second moment per mass along x, y, z, in units of size²
    "box": (1 / 12, 1 / 12, 1 / 12),
    "cylinder": (1 / 16, 1 / 16, 1 / 12),  # axis z
    "ellipsoid": (1 / 20, 1 / 20, 1 / 20),
}


@final
@dataclass(frozen=True)
class Mass:
    """A rigid body's mass distribution in its link frame.

    mass [kg]; centre: (3,) [m]; spread: (3, 3) ∫(x-c)(x-c)^T dm / m [m²], positive definite: so every Mass is possible.
    """

    mass: float
    centre: Array
    spread: Array

    @property
    def inertia(self) -> Array:
        """(3, 3) about the centre of mass [kg·m²]."""
        return np.asarray(self.mass * (np.trace(self.spread) * np.eye(3) - self.spread))

    @property
    def gyration(self) -> float:
        """Radius of gyration about the centre, sqrt(tr spread) [m]."""
        return float(np.sqrt(np.trace(self.spread)))

    def phi(self) -> Array:
        """(10,) in the order of `PHI_NAMES`, inertia about the link frame's origin."""
        second = self.spread + np.outer(self.centre, self.centre)
        I = self.mass * (np.trace(second) * np.eye(3) - second)  # noqa: E741
        moments = [I[0, 0], I[0, 1], I[1, 1], I[0, 2], I[1, 2], I[2, 2]]
        return np.array([self.mass, *(self.mass * self.centre), *moments])

    def moved(self, offset: Array) -> Mass:
        """The same body seen from a parallel frame in which the old origin lies at `offset`."""
        return Mass(self.mass, self.centre + offset, self.spread)


def of_shape(link: Link) -> Mass:
    """The link's shape, of even density."""
    return Mass(link.mass, np.array(link.centre), np.diag(np.array(_SPREAD[link.shape]) * np.square(link.size)))


def joined(parts: Iterable[Mass]) -> Mass:
    """Several bodies, given in one frame, as one."""
    bodies = list(parts)
    mass = sum(body.mass for body in bodies)
    centre = sum((body.mass * body.centre for body in bodies), np.zeros(3)) / mass
    spread = np.zeros((3, 3))
    for body in bodies:
        d = body.centre - centre
        spread += body.mass / mass * (body.spread + np.outer(d, d))
    return Mass(mass, centre, spread)
