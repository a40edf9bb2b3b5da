"""Where the bodies are, frame by frame: seen from the body that carries them, and the base in a world with a floor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from exogauge.robots.kinematics import Kinematics
from exogauge.robots.motion import Motion
from exogauge.robots.tree import RigidTree

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Poses:
    """F frames, N bodies. turn: (F, N, 4) wxyz, place: (F, N, 3) [m]."""

    turn: Array
    place: Array


@final
@dataclass(frozen=True)
class InBase:
    """F frames, N bodies, in the base link's frame (a fixed base's: the world). R: (F, N, 3, 3). p: (F, N, 3) [m]."""

    R: Array
    p: Array

    @classmethod
    def of(cls, tree: RigidTree, q: Array) -> InBase:
        """q: (F, J) [rad or m]."""
        still, none = np.zeros_like(q), np.zeros((len(q), 3))
        sweep = Kinematics(tree).sweep(Motion(q, still, still, none, none, none))
        return cls(np.moveaxis(sweep.R, 3, 0), np.moveaxis(sweep.p, 2, 0))

    def points(self, body: int, xyz: Array) -> Array:
        """(F, 3) [m] of a point of a body; body -1 is the fixed base. xyz: (3,) [m] in the body's frame."""
        if body < 0:
            return np.broadcast_to(xyz, (len(self.p), 3))
        found: Array = self.p[:, body] + self.R[:, body] @ xyz
        return found

    def seen_from_parents(self, tree: RigidTree) -> Poses:
        """Each body in its parent's frame; those without a parent in the base link's."""
        R, p = np.empty_like(self.R), np.empty_like(self.p)
        for i, up in enumerate(tree.parent):
            if up < 0:
                R[:, i], p[:, i] = self.R[:, i], self.p[:, i]
            else:
                to_parent = self.R[:, up].transpose(0, 2, 1)
                R[:, i] = to_parent @ self.R[:, i]
                p[:, i] = np.einsum("fij,fj->fi", to_parent, self.p[:, i] - self.p[:, up])
        return Poses(quaternions(R), p)


def quaternions(R: Array) -> Array:
    """(…, 4) wxyz, w ≥ 0. R: (…, 3, 3)."""
    flat = Rotation.from_matrix(R.reshape(-1, 3, 3)).as_quat(canonical=True, scalar_first=True)
    return np.asarray(flat).reshape(*R.shape[:-2], 4)


def upright(up: Array) -> Array:
    """(F, 3, 3) R_world_base that takes `up` (F, 3), seen from the base, to the world's z; its heading is +x."""
    forward = np.array([1.0, 0.0, 0.0]) - up * up[:, :1]
    forward /= np.maximum(np.linalg.norm(forward, axis=1, keepdims=True), 1e-9)
    return np.stack([forward, np.cross(up, forward), up], axis=1)


def planted(R_world_base: Array, feet: Array) -> Array:
    """(F, 3) [m] places of the base that hold the middle of the feet where it is, the lowest foot on the floor.

    feet: (K, F, 3) [m] in the base link.
    """
    seen = np.einsum("fij,kfj->kfi", R_world_base, feet)
    base: Array = -seen.mean(axis=0)
    base[:, 2] = -seen[:, :, 2].min(axis=0)
    return base
