"""Where links and via points are in one posture: what pretension, mirroring and a check of a routing look at."""

from __future__ import annotations

from typing import final

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from exogauge.devices.device import Band, ViaPoint
from exogauge.robots.tree import RigidTree

Array = NDArray[np.float64]


@final
class Posture:
    """Poses of all frames in the base link's frame (world, for a fixed base). q: (J,) [rad or m], default all zero."""

    def __init__(self, tree: RigidTree, q: Array | None = None) -> None:
        self._frames = tree.frames
        self._bodies: list[pin.SE3] = []
        for i, parent in enumerate(tree.parent):
            above = self._bodies[parent] if parent >= 0 else pin.SE3.Identity()
            moved = _moved(tree, i, q) if q is not None and tree.dof[i] >= 0 else pin.SE3.Identity()
            self._bodies.append(above * tree.T_before[i] * moved * tree.T_after[i])

    def pose(self, link: str) -> pin.SE3:
        """T_base_link."""
        body, T_body_link = self._frames[link]
        return self._bodies[body] * T_body_link if body >= 0 else T_body_link

    def place(self, point: ViaPoint) -> Array:
        """(3,) [m]"""
        return np.asarray(self.pose(point.link).act(np.array(point.xyz)))

    def length(self, band: Band) -> float:
        """[m] of the wire through a band's via points. Implements [Evaluator] (23)."""
        p = np.array([self.place(point) for point in band.via_points])
        return float(np.linalg.norm(np.diff(p, axis=0), axis=1).sum())


def _moved(tree: RigidTree, body: int, q: Array) -> pin.SE3:
    step = tree.axis[body] * q[tree.dof[body]]
    if tree.prismatic[body]:
        return pin.SE3(np.eye(3), step)
    return pin.SE3(pin.exp3(step), np.zeros(3))
