"""Where points of the robot are, and how far joints move them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.blind.generator.dynamics import Tree, path_down

Array = NDArray[np.float64]

Point = tuple[int, Array]  # moving body, -1 for the base, and (3,) [m] in its frame


@final
@dataclass(frozen=True)
class Poses:
    """Of every moving body at N samples, seen from the base. rotation: (N, 3, 3); origin: (N, 3) [m]."""

    tree: Tree
    rotation: list[Array]
    origin: list[Array]

    def at(self, point: Point) -> Array:
        """(N, 3) [m]"""
        body, xyz = point
        if body < 0:
            return np.tile(xyz, (len(self.origin[0]), 1))
        return np.asarray(self.origin[body] + self.rotation[body] @ xyz)

    def moves(self, point: Point) -> dict[int, Array]:
        """(N, 3) [m/rad] by which each joint below moves the point; joints that do not are left out."""
        place, body = self.at(point), point[0]
        chain = [] if body < 0 else (path_down(self.tree, body, -1) or [])
        return {
            joint: np.cross(self.rotation[joint][:, :, self.tree.axis[joint]], place - self.origin[joint])
            for joint in chain
        }


def poses(tree: Tree, q: Array) -> Poses:
    """q: (N, J) [rad]."""
    rotation, origin = list[Array](), list[Array]()
    for body, (above, r, axis) in enumerate(zip(tree.parent, tree.origin, tree.axis, strict=True)):
        turn = _about(axis, q[:, body])
        origin.append(origin[above] + rotation[above] @ r if above >= 0 else np.tile(r, (len(q), 1)))
        rotation.append(rotation[above] @ turn if above >= 0 else turn)
    return Poses(tree, rotation, origin)


def wire(at: Poses, points: Sequence[Point]) -> tuple[Array, Array, Array]:
    """Lengths (N, S) [m] of the stretches between points, their slopes (N, S, J) [m/rad], and the angles (N, S-1) [rad]
    by which the wire bends from each to the next."""
    places, moves = [at.at(point) for point in points], [at.moves(point) for point in points]
    samples, joints = len(places[0]), len(at.tree.parent)
    lengths, slopes = np.zeros((samples, len(points) - 1)), np.zeros((samples, len(points) - 1, joints))
    ways = list[Array]()
    for n in range(len(points) - 1):
        apart = places[n + 1] - places[n]
        lengths[:, n] = np.linalg.norm(apart, axis=1)
        along = apart / lengths[:, n, None]
        ways.append(along)
        for sign, moved in ((1.0, moves[n + 1]), (-1.0, moves[n])):
            for joint, way in moved.items():
                slopes[:, n, joint] += sign * np.sum(along * way, axis=1)
    bends = [np.arccos(np.clip(np.sum(a * b, axis=1), -1.0, 1.0)) for a, b in pairwise(ways)]
    return lengths, slopes, np.stack(bends, axis=1) if bends else np.zeros((samples, 0))


def _about(axis: int, angle: Array) -> Array:
    """(N, 3, 3) turns about a coordinate axis."""
    turn, j, k = np.zeros((len(angle), 3, 3)), (axis + 1) % 3, (axis + 2) % 3
    turn[:, axis, axis] = 1.0
    turn[:, j, j] = turn[:, k, k] = np.cos(angle)
    turn[:, k, j] = np.sin(angle)
    turn[:, j, k] = -turn[:, k, j]
    return turn
