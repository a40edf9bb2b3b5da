"""The rows of `robots.row_blocks`.

Time stays the innermost, contiguous loop, in tiles small enough for the cache, so that the compiler vectorises it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.loops.compiled import fused

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

TILE = 64  # samples


# In the kernels: m samples of a tile; x, y, z run over `axes`, a table that the compiler must not see, or it unrolls
# every loop three times and takes minutes. Rows of state arrays have TILE samples.


@fused(
    *(
        "b1, i8[::1], i8[::1], b1[::1], f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], i8[::1], "
        f"i8[::1], i8[::1], i8[::1], i8[:,::1], i8[::1], f8[::1], {signals}, f8[::1,:], i8[:,::1], i8[:,::1], i8[::1], "
        "f8[:,::1]"
        for signals in ("f8[:,:,:]", "f8[:,:,::1]")
    ),  # a part of a log, and a whole one
)
def fill_rows(
    floating: bool, parent: Ints, dof: Ints, prismatic: Bools,
    E_0: Array, E_c: Array, E_s: Array, axis: Array, before: Array, offset: Array,
    mass_first: Ints, mass_kind: Ints, inertia_first: Ints, inertia_kind: Ints,
    segments: Ints, movers: Ints, weights: Array,
    signals: Array, base: Array, axes: Ints, entries: Ints, first: Ints, whole: Array,
) -> None:  # fmt: skip
    """All tiles. signals: (5, J + 1, T) q, cos q, sin q, dq, ddq; the last joint is none.

    base: (9, T) acc, gyro, gyro_dot. whole: (rows, T)."""
    n, joints, samples = parent.shape[0], signals.shape[1], base.shape[1]
    R, B = np.empty((n + 1, 9, TILE)), np.empty((n + 1, 9, TILE))
    p, w, dw, b = (
        np.empty((n + 1, 3, TILE)), np.empty((n + 1, 3, TILE)), np.empty((n + 1, 3, TILE)), np.empty((n + 1, 3, TILE)),
    )  # fmt: skip
    S, joint = np.zeros((n, 6, TILE)), np.empty((5, joints, TILE))
    mass, inertia = np.empty((6, mass_kind.shape[0], TILE)), np.empty((3, inertia_kind.shape[0], TILE))
    every = np.ones(n, dtype=np.bool_)
    for start in range(0, samples, TILE):
        m = min(TILE, samples - start)
        for k in range(5):
            for j in range(joints):
                line = signals[k, j, start : start + m]
                for t in range(m):
                    joint[k, j, t] = line[t]
        _base_state(n, base[:, start : start + m], R, p, w, dw, b, m)
        _rigid(n, w, dw, B, axes, m)
        _sweep(parent, every, dof, prismatic, E_0, E_c, E_s, axis, before, offset, joint, axes, R, B, p, w, dw, b, S, m)
        _mass_columns(mass_first, mass_kind, axes, R, B, p, b, mass, m)
        _inertia_columns(inertia_first, inertia_kind, axes, entries, R, w, dw, inertia, m)
        if floating:
            _base_rows(mass, inertia, first, whole, start, m)
        _axis_rows(segments, movers, weights, S, mass, inertia, first, whole, start, m)


@fused()
def _base_state(n: int, base: Array, R: Array, p: Array, w: Array, dw: Array, b: Array, m: int) -> None:
    """Entry n: the base link itself."""
    for t in range(m):
        for k in range(9):
            R[n, k, t] = 1.0 if k % 4 == 0 else 0.0
        for x in range(3):
            p[n, x, t] = 0.0
            b[n, x, t] = base[x, t]
            w[n, x, t] = base[3 + x, t]
            dw[n, x, t] = base[6 + x, t]


@fused()
def _turned(R: Array, u: int, vector: Array, out: Array, axes: Ints, m: int) -> None:
    """out: (3, m) R of body u times a constant vector."""
    v0, v1, v2 = vector
    for x in axes[0]:
        for t in range(m):
            out[x, t] = R[u, 3 * x, t] * v0 + R[u, 3 * x + 1, t] * v1 + R[u, 3 * x + 2, t] * v2


@fused()
def _carried(B: Array, u: int, r: Array, out: Array, i: int, axes: Ints, m: int) -> None:
    """out[i] += B of body u times r: (3, m)."""
    for x in axes[0]:
        for t in range(m):
            out[i, x, t] += B[u, 3 * x, t] * r[0, t] + B[u, 3 * x + 1, t] * r[1, t] + B[u, 3 * x + 2, t] * r[2, t]


@fused()
def _rigid(i: int, w: Array, dw: Array, B: Array, axes: Ints, m: int) -> None:
    """B of body i: [α]× + [ω]×²."""
    for x in axes[0]:
        y, z = axes[1, x], axes[2, x]
        for t in range(m):
            B[i, 4 * x, t] = -w[i, y, t] * w[i, y, t] - w[i, z, t] * w[i, z, t]
        for t in range(m):
            B[i, 3 * y + x, t] = w[i, x, t] * w[i, y, t] + dw[i, z, t]
        for t in range(m):
            B[i, 3 * x + y, t] = w[i, x, t] * w[i, y, t] - dw[i, z, t]


@fused()
def _sweep(
    parent: Ints, needed: Bools, dof: Ints, prismatic: Bools, E_0: Array, E_c: Array, E_s: Array,
    axis: Array, before: Array, offset: Array, joint: Array, axes: Ints,
    R: Array, B: Array, p: Array, w: Array, dw: Array, b: Array, S: Array, m: int,
) -> None:  # fmt: skip
    """`Kinematics.sweep`, body after body, of those that are needed."""
    n = parent.shape[0]
    E, a, r = np.empty((9, TILE)), np.empty((3, TILE)), np.empty((3, TILE))
    step, s = np.empty((3, TILE)), np.empty((3, TILE))
    for i in range(n):
        if not needed[i]:
            continue
        u = parent[i] if parent[i] >= 0 else n
        j = dof[i]
        for k in range(E.shape[0]):
            e_0, e_c, e_s = E_0[i, k], E_c[i, k], E_s[i, k]
            for t in range(m):
                E[k, t] = e_0 + e_c * joint[1, j, t] + e_s * joint[2, j, t]
        for x in axes[0]:
            for y in axes[0]:
                for t in range(m):
                    R[i, 3 * x + y, t] = (
                        R[u, 3 * x, t] * E[y, t] + R[u, 3 * x + 1, t] * E[3 + y, t] + R[u, 3 * x + 2, t] * E[6 + y, t]
                    )
        _turned(R, u, axis[i], a, axes, m)
        _turned(R, u, before[i], r, axes, m)
        if prismatic[i]:
            _slide(i, u, j, joint, axes, a, r, step, w, dw, b, S, m)
        else:
            _turn(i, u, j, joint, axes, a, r, step, p, w, dw, b, S, m)
        for x in axes[0]:
            for t in range(m):
                p[i, x, t] = p[u, x, t] + r[x, t]
        _carried(B, u, r, b, i, axes, m)
        _rigid(i, w, dw, B, axes, m)
        if np.any(offset[i] != 0.0):
            _turned(R, i, offset[i], s, axes, m)
            _carried(B, i, s, b, i, axes, m)
            for x in axes[0]:
                for t in range(m):
                    p[i, x, t] += s[x, t]


@fused()
def _turn(
    i: int, u: int, j: int, joint: Array, axes: Ints, a: Array, r: Array, step: Array,
    p: Array, w: Array, dw: Array, b: Array, S: Array, m: int,
) -> None:  # fmt: skip
    """What a revolute joint adds; b starts as the parent's."""
    for x in axes[0]:
        for t in range(m):
            step[x, t] = a[x, t] * joint[3, j, t]
        for t in range(m):
            w[i, x, t] = w[u, x, t] + step[x, t]
        for t in range(m):
            dw[i, x, t] = dw[u, x, t] + a[x, t] * joint[4, j, t]
        for t in range(m):
            b[i, x, t] = b[u, x, t]
        for t in range(m):
            S[i, 3 + x, t] = a[x, t]
    for x in axes[0]:
        y, z = axes[1, x], axes[2, x]
        for t in range(m):
            dw[i, x, t] += w[u, y, t] * step[z, t] - w[u, z, t] * step[y, t]
        for t in range(m):
            S[i, x, t] = (p[u, y, t] + r[y, t]) * a[z, t] - (p[u, z, t] + r[z, t]) * a[y, t]


@fused()
def _slide(
    i: int, u: int, j: int, joint: Array, axes: Ints, a: Array, r: Array, step: Array,
    w: Array, dw: Array, b: Array, S: Array, m: int,
) -> None:  # fmt: skip
    """What a prismatic joint adds; b starts as the parent's plus the joint's own and Coriolis acceleration."""
    for x in axes[0]:
        for t in range(m):
            step[x, t] = 2.0 * a[x, t] * joint[3, j, t]
            r[x, t] += a[x, t] * joint[0, j, t]
            w[i, x, t] = w[u, x, t]
            dw[i, x, t] = dw[u, x, t]
            S[i, x, t] = a[x, t]
            S[i, 3 + x, t] = 0.0
    for x in axes[0]:
        y, z = axes[1, x], axes[2, x]
        for t in range(m):
            b[i, x, t] = b[u, x, t] + a[x, t] * joint[4, j, t] + w[u, y, t] * step[z, t] - w[u, z, t] * step[y, t]


@fused()
def _mass_columns(
    mass_first: Ints, mass_kind: Ints, axes: Ints, R: Array, B: Array, p: Array, b: Array, mass: Array, m: int
) -> None:
    """`cut_rows.mass_columns`."""
    for i in range(mass_first.shape[0] - 1):
        for c in range(mass_first[i], mass_first[i + 1]):
            k = mass_kind[c] - 1
            for x in axes[0]:
                if k < 0:
                    for t in range(m):
                        mass[x, c, t] = b[i, x, t]
                else:
                    for t in range(m):
                        mass[x, c, t] = (
                            B[i, 3 * x, t] * R[i, k, t]
                            + B[i, 3 * x + 1, t] * R[i, 3 + k, t]
                            + B[i, 3 * x + 2, t] * R[i, 6 + k, t]
                        )
            for x in axes[0]:
                y, z = axes[1, x], axes[2, x]
                for t in range(m):
                    mass[3 + x, c, t] = p[i, y, t] * mass[z, c, t] - p[i, z, t] * mass[y, c, t]
                if k >= 0:
                    for t in range(m):
                        mass[3 + x, c, t] += R[i, 3 * y + k, t] * b[i, z, t] - R[i, 3 * z + k, t] * b[i, y, t]


@fused()
def _inertia_columns(
    inertia_first: Ints, inertia_kind: Ints, axes: Ints, entries: Ints,
    R: Array, w: Array, dw: Array, inertia: Array, m: int,
) -> None:  # fmt: skip
    """`cut_rows.inertia_columns`."""
    U, w_body, dw_body = np.empty((9, TILE)), np.empty((3, TILE)), np.empty((3, TILE))
    for i in range(inertia_first.shape[0] - 1):
        for k in axes[0]:
            for t in range(m):
                w_body[k, t] = R[i, k, t] * w[i, 0, t] + R[i, 3 + k, t] * w[i, 1, t] + R[i, 6 + k, t] * w[i, 2, t]
            for t in range(m):
                dw_body[k, t] = R[i, k, t] * dw[i, 0, t] + R[i, 3 + k, t] * dw[i, 1, t] + R[i, 6 + k, t] * dw[i, 2, t]
            for x in axes[0]:
                y, z = axes[1, x], axes[2, x]
                for t in range(m):
                    U[3 * x + k, t] = w[i, y, t] * R[i, 3 * z + k, t] - w[i, z, t] * R[i, 3 * y + k, t]
        for c in range(inertia_first[i], inertia_first[i + 1]):
            k, l = entries[inertia_kind[c], 0], entries[inertia_kind[c], 1]  # noqa: E741 (entry k, l)
            for x in axes[0]:
                for t in range(m):
                    inertia[x, c, t] = R[i, 3 * x + k, t] * dw_body[l, t] + U[3 * x + k, t] * w_body[l, t]
                if k != l:
                    for t in range(m):
                        inertia[x, c, t] += R[i, 3 * x + l, t] * dw_body[k, t] + U[3 * x + l, t] * w_body[k, t]


@fused()
def _base_rows(mass: Array, inertia: Array, first: Ints, whole: Array, start: int, m: int) -> None:
    """The six base rows are the columns themselves; force rows have none of inertia."""
    for r in range(mass.shape[0]):
        for c in range(mass.shape[1]):
            line = whole[first[r] + c, start : start + m]
            for t in range(m):
                line[t] = mass[r, c, t]
    for r in range(inertia.shape[0]):
        for c in range(inertia.shape[1]):
            line = whole[first[3 + r] + mass.shape[1] + c, start : start + m]
            for t in range(m):
                line[t] = inertia[r, c, t]


@fused()
def _axis_rows(
    segments: Ints, movers: Ints, weights: Array, S: Array, mass: Array, inertia: Array,
    first: Ints, whole: Array, start: int, m: int,
) -> None:  # fmt: skip
    """Per segment, the weighted joint motions times its columns."""
    V = np.empty((6, TILE))
    for g in range(segments.shape[0]):
        for x in range(V.shape[0]):
            for t in range(m):
                V[x, t] = 0.0
            for k in range(segments[g, 5], segments[g, 6]):
                body, weight = movers[k], weights[k]
                for t in range(m):
                    V[x, t] += weight * S[body, x, t]
        c_first, c_last, place = segments[g, 2], segments[g, 3], first[segments[g, 0]] + segments[g, 4]
        for c in range(c_first, c_last):
            line = whole[place + c - c_first, start : start + m]
            if segments[g, 1]:
                for t in range(m):
                    line[t] = V[3, t] * inertia[0, c, t] + V[4, t] * inertia[1, c, t] + V[5, t] * inertia[2, c, t]
            else:
                for t in range(m):
                    line[t] = V[0, t] * mass[0, c, t] + V[1, t] * mass[1, c, t] + V[2, t] * mass[2, c, t]
                for t in range(m):
                    line[t] += V[3, t] * mass[3, c, t] + V[4, t] * mass[4, c, t] + V[5, t] * mass[5, c, t]
