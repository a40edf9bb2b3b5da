"""Lengths of bands and their Jacobians, for `devices.routing`.

Time is the innermost, contiguous loop, in tiles small enough for the cache, so that the compiler vectorises it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.loops.compiled import fused

Array = NDArray[np.float64]
Ints = NDArray[np.intp]
Bools = NDArray[np.bool_]

TILE = 64  # samples
TINY = 1e-150  # as in `devices.wire_layout`


# In the kernels: m samples of a tile; x, y, z run over `axes`, a table that the compiler must not see, or it unrolls
# every loop. State arrays have TILE samples.


@fused(
    "i8[::1], b1[::1], f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], i8[::1], f8[:,::1], i8[::1], i8[::1], "
    "i8[::1], f8[::1], i8[::1], i8[::1], i8[::1], f8[:,::1], f8[:,:,::1], i8[:,::1], i8, f8[:,::1], f8[:,:,::1]",
    "i8[::1], b1[::1], f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], i8[::1], f8[:,::1], i8[::1], i8[::1], "
    "i8[::1], f8[::1], i8[:], i8[:], i8[::1], f8[:,::1], f8[:,:,::1], i8[:,::1], i8, f8[:,::1], f8[:,:,::1]",
)
def measure_wires(
    parent: Ints, prismatic: Bools, E_0: Array, E_c: Array, E_s: Array, before: Array, axis: Array,
    point_joint: Ints, point: Array, start: Ints, end: Ints, wire: Ints, constant: Array,
    pair_wire: Ints, pair_joint: Ints, pair_column: Ints, carried: Array,
    signals: Array, axes: Ints, first: int, length: Array, jacobian: Array,
) -> None:  # fmt: skip
    """All tiles. signals: (3, D, T) q, cos q, sin q, from sample `first` of length (W, ·) and jacobian on."""
    joints, samples = signals.shape[1], signals.shape[2]
    R, place, a = np.empty((joints, 9, TILE)), np.empty((joints, 3, TILE)), np.empty((joints, 3, TILE))
    p, line = np.empty((point.shape[0], 3, TILE)), np.empty((wire.shape[0], 6, TILE))
    S, total = np.empty((joints, 6, TILE)), np.empty((6, TILE))
    slopes = jacobian.shape[0] > 0
    for begin in range(0, samples, TILE):
        m = min(TILE, samples - begin)
        _move(parent, prismatic, E_0, E_c, E_s, before, axis, signals[:, :, begin : begin + m], axes, R, place, a, m)
        _points(point_joint, point, axes, R, place, p, m)
        at = first + begin
        for w in range(constant.shape[0]):
            for t in range(m):
                length[w, at + t] = constant[w]
        _segments(start, end, wire, p, axes, slopes, line, length[:, at : at + m], m)
        if slopes:
            _motions(prismatic, place, a, axes, S, m)
            for k in range(pair_wire.shape[0]):
                out = jacobian[pair_wire[k], pair_column[k], at : at + m]
                _slope(carried[k], line, S[pair_joint[k]], total, out, m)


@fused()
def _move(
    parent: Ints, prismatic: Bools, E_0: Array, E_c: Array, E_s: Array, before: Array, axis: Array,
    signals: Array, axes: Ints, R: Array, place: Array, a: Array, m: int,
) -> None:  # fmt: skip
    """Rotation (9), place (3) and axis (3) of every joint, parents first."""
    E = np.empty((9, TILE))
    for k in range(parent.shape[0]):
        u = parent[k]
        if u < 0:
            for i in range(E_0.shape[1]):
                for t in range(m):
                    R[k, i, t] = E_0[k, i] + E_c[k, i] * signals[1, k, t] + E_s[k, i] * signals[2, k, t]
            for x in axes[0]:
                for t in range(m):
                    place[k, x, t] = before[k, x]
                for t in range(m):
                    a[k, x, t] = axis[k, x]
        else:
            for i in range(E_0.shape[1]):
                for t in range(m):
                    E[i, t] = E_0[k, i] + E_c[k, i] * signals[1, k, t] + E_s[k, i] * signals[2, k, t]
            for x in axes[0]:
                for y in axes[0]:
                    for t in range(m):
                        R[k, 3 * x + y, t] = (
                            R[u, 3 * x, t] * E[y, t]
                            + R[u, 3 * x + 1, t] * E[3 + y, t]
                            + R[u, 3 * x + 2, t] * E[6 + y, t]
                        )
            _turned(R[u], before[k], axes, place[k], m)
            _turned(R[u], axis[k], axes, a[k], m)
            for x in axes[0]:
                for t in range(m):
                    place[k, x, t] += place[u, x, t]
        if prismatic[k]:
            for x in axes[0]:
                for t in range(m):
                    place[k, x, t] += a[k, x, t] * signals[0, k, t]


@fused()
def _turned(R: Array, vector: Array, axes: Ints, out: Array, m: int) -> None:
    """out: (3, m) R times a constant vector."""
    v0, v1, v2 = vector
    for x in axes[0]:
        for t in range(m):
            out[x, t] = R[3 * x, t] * v0 + R[3 * x + 1, t] * v1 + R[3 * x + 2, t] * v2


@fused()
def _points(point_joint: Ints, point: Array, axes: Ints, R: Array, place: Array, p: Array, m: int) -> None:
    for i in range(point_joint.shape[0]):
        k = point_joint[i]
        if k < 0:
            for x in axes[0]:
                for t in range(m):
                    p[i, x, t] = point[i, x]
        else:
            _turned(R[k], point[i], axes, p[i], m)
            for x in axes[0]:
                for t in range(m):
                    p[i, x, t] += place[k, x, t]


@fused()
def _segments(
    start: Ints, end: Ints, wire: Ints, p: Array, axes: Ints, slopes: bool, line: Array, length: Array, m: int
) -> None:
    """Adds each segment to its wire's length; its line [e; p x e] where slopes are wanted."""
    l = np.empty(TILE)  # noqa: E741 (the paper's letter)
    for s in range(start.shape[0]):
        a, b, e = p[start[s]], p[end[s]], line[s]
        for x in axes[0]:
            for t in range(m):
                e[x, t] = b[x, t] - a[x, t]
        for t in range(m):
            l[t] = np.sqrt(e[0, t] * e[0, t] + e[1, t] * e[1, t] + e[2, t] * e[2, t])
        of_wire = length[wire[s]]
        for t in range(m):
            of_wire[t] += l[t]
        if slopes:
            for t in range(m):
                l[t] = 1.0 / max(l[t], TINY)
            for x in axes[0]:
                for t in range(m):
                    e[x, t] *= l[t]
            for x in axes[0]:
                y, z = axes[1, x], axes[2, x]
                for t in range(m):
                    e[3 + x, t] = a[y, t] * e[z, t] - a[z, t] * e[y, t]


@fused()
def _motions(prismatic: Bools, place: Array, a: Array, axes: Ints, S: Array, m: int) -> None:
    """[linear; angular] motion about the origin per unit velocity of each joint."""
    for k in range(prismatic.shape[0]):
        for x in axes[0]:
            y, z = axes[1, x], axes[2, x]
            if prismatic[k]:
                for t in range(m):
                    S[k, x, t] = a[k, x, t]
                for t in range(m):
                    S[k, 3 + x, t] = 0.0
            else:
                for t in range(m):
                    S[k, x, t] = place[k, y, t] * a[k, z, t] - place[k, z, t] * a[k, y, t]
                for t in range(m):
                    S[k, 3 + x, t] = a[k, x, t]


@fused()
def _slope(carried: Array, line: Array, S: Array, total: Array, out: Array, m: int) -> None:
    """out: (m,) the joint's motion times the sum of the lines it carries."""
    for x in range(total.shape[0]):
        for t in range(m):
            total[x, t] = 0.0
        for s in range(carried.shape[0]):
            sign = carried[s]
            if sign != 0.0:
                for t in range(m):
                    total[x, t] += sign * line[s, x, t]
    for t in range(m):
        out[t] = S[0, t] * total[0, t] + S[1, t] * total[1, t] + S[2, t] * total[2, t]
    for t in range(m):
        out[t] += S[3, t] * total[3, t] + S[4, t] * total[4, t] + S[5, t] * total[5, t]
