"""Names and units of the inertial parameters, body by body, in the order of `RigidTree.phi`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.robots.tree import RigidTree

Array = NDArray[np.float64]

SYMBOLS = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")
UNITS = ("kg", *("kg·m",) * 3, *("kg·m²",) * 6)


def parameter_names(tree: RigidTree) -> tuple[str, ...]:
    """(10N,) `m[link]` mass, `mx[link]` … first moments, `Ixx[link]` … inertia about the link frame's origin."""
    return tuple(f"{symbol}[{body}]" for body in tree.bodies for symbol in SYMBOLS)


def parameter_units(tree: RigidTree) -> tuple[str, ...]:
    """(10N,) SI units."""
    return UNITS * len(tree.bodies)


def of_slide(unit: str) -> str:
    """A turning joint's unit as that of one that slides: N·m·s/rad is N·s/m, kg·m² is kg, N·m/A is N/A."""
    return unit.replace("kg·m²", "kg").replace("N·m", "N").replace("rad", "m")


def inertia_by_first_moment(c: Array) -> Array:
    """(6, 3) of the inertia about the origin by m c where the mass keeps its inertia about its centre c (3,)."""
    x, y, z = c
    return np.array([
        [0.0, 2 * y, 2 * z], [-y, -x, 0.0], [2 * x, 0.0, 2 * z],
        [-z, 0.0, -x], [0.0, -z, -y], [2 * x, 2 * y, 0.0],
    ])  # fmt: skip
