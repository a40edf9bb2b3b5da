"""Where a device's via points are while the robot takes some postures: what a check of the device file looks at."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from exogauge.robots.kinematics import Kinematics
from exogauge.robots.motion import Motion
from exogauge.robots.tree import RigidTree

Array = NDArray[np.float64]
Point = tuple[int, Array]
"""(body index, -1 = fixed base; place in that body [m])."""

DRAWN = 400
WIDEST_TURN, WIDEST_SLIDE = np.pi, 0.5  # [rad], [m] to either side where a joint has no limits


@final
class Postures:
    """T postures of a robot; the first is all joints at zero. q: (T, J) [rad or m]."""

    def __init__(self, tree: RigidTree, q: Array) -> None:
        self.tree, self.q = tree, q
        rest, none = np.zeros_like(q), np.zeros((len(q), 3))
        sweep = Kinematics(tree).sweep(Motion(q, rest, rest, none, none, none))
        self._R, self._p = sweep.R, sweep.p

    def place(self, points: Sequence[Point]) -> Array:
        """(T, len(points), 3) [m] in the base link's frame (world, for a fixed base)."""
        placed = np.empty((len(self.q), len(points), 3))
        for k, (body, xyz) in enumerate(points):
            placed[:, k] = xyz if body < 0 else np.einsum("ijt,j->ti", self._R[body], xyz) + self._p[body].T
        return placed

    def lengths(self, points: Sequence[Point]) -> Array:
        """(T,) [m] of a wire through the points in order."""
        total: Array = np.linalg.norm(np.diff(self.place(points), axis=1), axis=2).sum(axis=1)
        return total


def locate(tree: RigidTree, link: str, xyz: Sequence[float]) -> Point:
    """The body that carries a point given in the frame of a link. Links joined by fixed joints are one body."""
    body, T_body_link = tree.frames[link]
    return body, np.asarray((T_body_link * pin.SE3(np.eye(3), np.array(xyz))).translation)


def drawn_postures(tree: RigidTree, count: int = DRAWN) -> Postures:
    """Zero, then postures drawn evenly within the joints' limits, always the same ones."""
    widest = np.where(_slides(tree), WIDEST_SLIDE, WIDEST_TURN)
    lower = np.where(np.isfinite(tree.lower), tree.lower, -widest)
    upper = np.where(np.isfinite(tree.upper), tree.upper, widest)
    drawn = np.random.default_rng(0).uniform(lower, upper, size=(count, len(tree.joints)))
    return Postures(tree, np.vstack([np.zeros(len(tree.joints)), drawn]))


def _slides(tree: RigidTree) -> NDArray[np.bool_]:
    """(J,)"""
    slides = np.zeros(len(tree.joints), dtype=np.bool_)
    moved = tree.dof >= 0
    slides[tree.dof[moved]] = tree.prismatic[moved]
    return slides
