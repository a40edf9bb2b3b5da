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
    from exogauge.loops.body import move_body

    R, p = np.empty((*q.shape, 3, 3)), np.empty((*q.shape, 3))
    offset = body.offset * scale[body.stretch]
    move_body(body.parent, body.prismatic, *body.axes, offset, np.cos(q), np.where(body.prismatic, q, np.sin(q)), R, p)
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


def scale_slopes(body: HumanBody, at: Pose, points: Points) -> Array:
    """(T, M, 3, S) of the points' places by the scales; by a point's own offset they are its part's rotation."""
    T, K, S = *at.position.shape[:2], len(SCALES)
    by_scale = np.zeros((T, K, 3, S))
    for k, parent in enumerate(body.parent):
        if parent >= 0:
            by_scale[:, k] = by_scale[:, parent]
            for a in range(3):
                by_scale[:, k, :, body.stretch[k, a]] += at.rotation[:, parent, :, a] * body.offset[k, a]
    G = by_scale[:, points.joint]
    for m, joint in enumerate(points.joint):
        for a in range(3):
            G[:, m, :, points.stretch[m, a]] += at.rotation[:, joint, :, a] * points.nominal[m, a]
    return np.asarray(G)


def beyond(body: HumanBody, q: Array, sd: float) -> tuple[Array, Array]:
    """(T, K) by how much postures lie beyond the joints' reach, over sd², and 1 / sd² where they do: of the sum
    Σ (q - reach)² / sd², half its slope and half its second derivative."""
    off = q - np.clip(q, *body.reach)
    return off * sd**-2, np.where(off != 0.0, sd**-2, 0.0)


def normal(body: HumanBody, at: Pose, points: Points, place: Array, left: Array, weight: Array) -> tuple[Array, Array]:
    """JᵀWJ (T, K, K) and JᵀWr (T, K) of the slopes J of `place` (T, M, 3) and what is left of it, r (T, M, 3), without
    the slopes themselves. weight: (T, M), 0 where a point is not seen; r is finite there.

    A slope is ω × p + v with the joint's own ω, v; so what two joints share are moments of the points that the upper
    one of them moves and the other one too, summed from the ends inwards (as inertias are: Featherstone 2008, 6.2).
    """
    from exogauge.loops.body import normal_equations

    T, K = at.position.shape[:2]
    A, g = np.zeros((T, K, K)), np.empty((T, K))
    axis, sign = body.axes
    place, left, weight = (np.ascontiguousarray(each) for each in (place, left, weight))
    normal_equations(
        body.parent, body.prismatic, axis, sign, points.joint, at.rotation, at.position, place, left, weight, A, g
    )
    return A, g
