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
    """JᵀWJ (K, K, T) and JᵀWr (K, T) of the slopes J of `place` (T, M, 3) and what is left of it, r (T, M, 3), without
    the slopes themselves. weight: (T, M), 0 where a point is not seen; r is finite there.

    A slope is ω × p + v with the joint's own ω, v; so what two joints share are moments of the points that the upper
    one of them moves and the other one too, summed from the ends inwards (as inertias are: Featherstone 2008, 6.2).
    """
    T, K = at.position.shape[:2]
    here = at.position[:, [K - 1]]  # moments about a point of the body, for their digits
    p, o = (np.ascontiguousarray(np.moveaxis(each - here, 0, 2)) for each in (place, at.position))  # (.., 3, T)
    w, r = np.ascontiguousarray(weight.T), np.moveaxis(left, 0, 2) * weight.T[:, None]
    moves = np.zeros((K, 6, T))  # ω, v
    for k, axis in enumerate(body.axis):
        a = int(np.abs(axis).argmax())
        along = axis[a] * at.rotation[:, k, :, a].T
        moves[k, 3:] = along if body.prismatic[k] else _cross(o[k], along)
        if not body.prismatic[k]:
            moves[k, :3] = along
    mass, first, second, pull = np.zeros((K, T)), np.zeros((K, 3, T)), np.zeros((K, 3, 3, T)), np.zeros((K, 6, T))
    for m, joint in enumerate(points.joint):
        weighted = w[m] * p[m]
        mass[joint] += w[m]
        first[joint] += weighted
        second[joint] += weighted[:, None] * p[m]
        pull[joint, :3] += _cross(p[m], r[m])
        pull[joint, 3:] += r[m]
    A, g = np.zeros((K, K, T)), np.empty((K, T))
    for k in reversed(range(K)):
        above = int(body.parent[k])
        if above >= 0:
            for each in (mass, first, second, pull):
                each[above] += each[k]
        omega, v = moves[k, :3], moves[k, 3:]
        g[k] = np.sum(moves[k] * pull[k], axis=0)
        felt = _cross(omega, first[k]) + mass[k] * v
        if not body.prismatic[k]:
            square = second[k, 0, 0] + second[k, 1, 1] + second[k, 2, 2]
            turned = square * omega - np.sum(second[k] * omega, axis=1) + _cross(first[k], v)
        else:
            turned = _cross(first[k], v)
        for j in np.flatnonzero(body.above[k]):
            other = moves[j]
            A[j, k] = other[3] * felt[0] + other[4] * felt[1] + other[5] * felt[2]
            if not body.prismatic[j]:
                A[j, k] += other[0] * turned[0] + other[1] * turned[1] + other[2] * turned[2]
            A[k, j] = A[j, k]
    return A, g


def _cross(a: Array, b: Array) -> Array:
    """Of (3, T) each."""
    out = np.empty_like(b)
    for x, y, z in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        np.multiply(a[y], b[z], out=out[x])
        out[x] -= a[z] * b[y]
    return out
