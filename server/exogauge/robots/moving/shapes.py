"""Convex shapes that stand for a robot's links where it must not touch itself or the floor."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, final

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

Array = NDArray[np.float64]
Kind = Literal["box", "sphere", "cylinder", "capsule", "hull"]


@final
@dataclass(frozen=True)
class Shape:
    """link: of the URDF. at: in its frame. size [m]: edges of a box, radius of a sphere, radius and length of a
    cylinder or of a capsule without its caps, both along z. points: (K, 3) [m] corners of a hull."""

    link: str
    kind: Kind
    size: tuple[float, ...] = ()
    at: pin.SE3 = field(default_factory=pin.SE3.Identity)
    points: Array = field(default_factory=lambda: np.zeros((0, 3)))

    def solid(self) -> coal.CollisionGeometry:
        """As coal knows it."""
        if self.kind == "box":
            return coal.Box(*self.size)
        if self.kind == "sphere":
            return coal.Sphere(*self.size)
        if self.kind == "cylinder":
            return coal.Cylinder(*self.size)
        if self.kind == "capsule":
            return coal.Capsule(*self.size)
        corners = coal.StdVec_Vec3s()
        corners.extend([np.array(point) for point in self.points])
        return coal.ConvexBase.convexHull(corners, False, "")
