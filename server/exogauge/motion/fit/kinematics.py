"""Where the body and its points are, in many frames at once, and the slopes of that."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.motion.fit.body import SCALES, HumanBody

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


@final
@dataclass(frozen=True)
class Points:
    """M points on the body. joint: (M,) that carries each. nominal: (M, 3) [m] in its part at scales 1.

    stretch: (M, 3) which of SCALES stretches each component.
    """

    joint: Indices
    nominal: Array
    stretch: Indices


@final
@dataclass(frozen=True)
class Pose:
    """rotation: (T, K, 3, 3) R_world_part behind each joint; position: (T, K, 3) [m] of the joint."""

    rotation: Array
    position: Array


def pose(body: HumanBody, q: Array, scale: Array) -> Pose:
    """q: (T, K) [m, rad]; scale: (S,)."""
    R, p = np.empty((*q.shape, 3, 3)), np.empty((*q.shape, 3))
    for k, parent in enumerate(body.parent):
        t = body.offset[k] * scale[body.stretch[k]]
        R_p = R[:, parent] if parent >= 0 else np.broadcast_to(np.eye(3), (len(q), 3, 3))
        p[:, k] = (p[:, parent] if parent >= 0 else 0.0) + R_p @ t
        if body.prismatic[k]:
            R[:, k] = R_p
            p[:, k] += q[:, k, None] * (R_p @ body.axis[k])
            continue
        a = int(np.abs(body.axis[k]).argmax())
        b, c = (a + 1) % 3, (a + 2) % 3
        cos, sin = np.cos(q[:, k, None]), np.sin(q[:, k, None]) * body.axis[k, a]
        R[:, k, :, a] = R_p[..., a]
        R[:, k, :, b] = R_p[..., b] * cos + R_p[..., c] * sin
        R[:, k, :, c] = R_p[..., c] * cos - R_p[..., b] * sin
    return Pose(R, p)


def places(at: Pose, points: Points, scale: Array, offset: Array) -> Array:
    """(T, M, 3) [m], world. offset: (M, 3) [m] in the points' parts, beside the nominal places."""
    local = points.nominal * scale[points.stretch] + offset
    placed: Array = at.position[:, points.joint] + np.einsum("tmab,mb->tma", at.rotation[:, points.joint], local)
    return placed


def slopes(body: HumanBody, at: Pose, points: Points, place: Array) -> Array:
    """(T, 3 M, K) of `place` (T, M, 3) by the coordinates."""
    T, M = place.shape[:2]
    J = np.zeros((T, M, 3, len(body.parent)))
    for k in range(len(body.parent)):
        a = int(np.abs(body.axis[k]).argmax())
        axis = body.axis[k, a] * at.rotation[:, k, :, a]
        moved = np.flatnonzero(body.above[points.joint, k])
        if body.prismatic[k]:
            J[..., k][:, moved] = axis[:, None]
            continue
        x, y, z = np.moveaxis(place[:, moved] - at.position[:, None, k], 2, 0)
        u, v, w = axis.T[:, :, None]
        J[:, moved, 0, k] = v * z - w * y
        J[:, moved, 1, k] = w * x - u * z
        J[:, moved, 2, k] = u * y - v * x
    return J.reshape(T, 3 * M, -1)


def shared_slopes(body: HumanBody, at: Pose, points: Points) -> Array:
    """(T, 3 M, S + 3 M) by the scales, then by the points' offsets."""
    T, K, S, M = *at.position.shape[:2], len(SCALES), len(points.joint)
    by_scale = np.zeros((T, K, 3, S))
    for k, parent in enumerate(body.parent):
        if parent >= 0:
            by_scale[:, k] = by_scale[:, parent]
            for a in range(3):
                by_scale[:, k, :, body.stretch[k, a]] += at.rotation[:, parent, :, a] * body.offset[k, a]
    G = np.zeros((T, M, 3, S + 3 * M))
    G[..., :S] = by_scale[:, points.joint]
    for m, joint in enumerate(points.joint):
        for a in range(3):
            G[:, m, :, points.stretch[m, a]] += at.rotation[:, joint, :, a] * points.nominal[m, a]
        G[:, m, :, S + 3 * m : S + 3 * m + 3] = at.rotation[:, joint]
    return G.reshape(T, 3 * M, -1)
