"""What bodies with given parameters ask of base, joints and sensors: the rows of `loops.rows` times these.

No row is built. Inward over the bodies, each wrench about the base origin; a joint bears what its subtree asks for.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.loops.compiled import fused
from exogauge.loops.rows import TILE, _base_state, _rigid, _sweep

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


@fused(
    *(
        "i8[::1], i8[::1], b1[::1], f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], f8[:,:,::1], "
        f"b1[:,::1], b1[:,::1], i8[::1], f8[:,::1], f8[:,::1], {signals}, f8[::1,:], i8[:,::1], f8[:,:,::1]"
        for signals in ("f8[:,:,:]", "f8[:,:,::1]")
    ),  # a part of a log, and a whole one
)
def fill_loads(
    parent: Ints, dof: Ints, prismatic: Bools,
    E_0: Array, E_c: Array, E_s: Array, axis: Array, before: Array, offset: Array,
    phi: Array, live: Bools, beyond: Bools, frame_body: Ints, frame_R: Array, frame_p: Array,
    signals: Array, base: Array, axes: Ints, out: Array,
) -> None:  # fmt: skip
    """signals, base: as `fill_rows`. phi: (L, n, 10), live: (L, n) any of it not zero. beyond: (C, n) bodies that each
    sensor carries; its frame_body (-1: the base), frame_R (C, 9) and frame_p (C, 3) in that.

    out: (L, 6 + J + 6 C, T) base force and moment, joints, each sensor's force and moment in its frame. What the base
    itself asks for is that of a body without a joint.
    """
    n, joints, samples = parent.shape[0], signals.shape[1], base.shape[1]
    R, B = np.empty((n + 1, 9, TILE)), np.empty((n + 1, 9, TILE))
    p, w, dw, b = (
        np.empty((n + 1, 3, TILE)), np.empty((n + 1, 3, TILE)), np.empty((n + 1, 3, TILE)), np.empty((n + 1, 3, TILE)),
    )  # fmt: skip
    S, joint = np.zeros((n, 6, TILE)), np.empty((5, joints, TILE))
    total, carried = np.empty((n + 1, 6, TILE)), np.empty((6, TILE))
    own, h, v, u, turned = (
        np.empty((6, TILE)), np.empty((3, TILE)), np.empty((3, TILE)), np.empty((3, TILE)), np.empty((3, TILE)),
    )  # fmt: skip
    needed = np.zeros(n, dtype=np.bool_)  # how bodies move that bear nothing matters to what they carry only
    for c in frame_body:
        needed[max(c, 0)] = True
    for back in range(n):
        i = n - 1 - back
        needed[i] |= np.any(live[:, i])
        if needed[i] and parent[i] >= 0:
            needed[parent[i]] = True
    for start in range(0, samples, TILE):
        m = min(TILE, samples - start)
        for k in range(5):
            for j in range(joints):
                line = signals[k, j, start : start + m]
                for t in range(m):
                    joint[k, j, t] = line[t]
        _base_state(n, base[:, start : start + m], R, p, w, dw, b, m)
        _rigid(n, w, dw, B, axes, m)
        _sweep(
            parent, needed, dof, prismatic, E_0, E_c, E_s, axis, before, offset, joint, axes, R, B, p, w, dw, b, S, m
        )
        for which in range(phi.shape[0]):
            result = out[which]
            for i in range(n + 1):
                for x in range(total.shape[1]):
                    for t in range(m):
                        total[i, x, t] = 0.0
            for k in range(6 + joints - 1, result.shape[0]):
                for t in range(m):
                    result[k, start + t] = 0.0
            for back in range(n):
                i = n - 1 - back
                if live[which, i]:
                    _asked(i, phi[which, i], axes, R, B, p, w, dw, b, own, h, v, u, turned, m)
                    for x in range(total.shape[1]):
                        for t in range(m):
                            total[i, x, t] += own[x, t]
                    for c in range(beyond.shape[0]):
                        if beyond[c, i]:
                            first = 6 + joints - 1 + 6 * c
                            for x in range(total.shape[1]):
                                for t in range(m):
                                    result[first + x, start + t] += own[x, t]
                if dof[i] < joints - 1:  # of a body that is not needed S, and its sum, are zero
                    line = result[6 + dof[i], start : start + m]
                    for t in range(m):
                        line[t] = 0.0
                    for x in range(total.shape[1]):
                        for t in range(m):
                            line[t] += S[i, x, t] * total[i, x, t]
                above = parent[i] if parent[i] >= 0 else n
                for x in range(total.shape[1]):
                    for t in range(m):
                        total[above, x, t] += total[i, x, t]
            for x in range(total.shape[1]):
                line = result[x, start : start + m]
                for t in range(m):
                    line[t] = total[n, x, t]
            for c in range(beyond.shape[0]):
                first = 6 + joints - 1 + 6 * c
                for x in range(carried.shape[0]):
                    for t in range(m):
                        carried[x, t] = result[first + x, start + t]
                body = frame_body[c] if frame_body[c] >= 0 else n
                _into_frame(body, frame_R[c], frame_p[c], axes, R, p, carried, h, v, u, m)
                for x in axes[0]:
                    for t in range(m):
                        result[first + x, start + t] = u[x, t]
                        result[first + 3 + x, start + t] = v[x, t]


@fused()
def _asked(
    i: int, phi: Array, axes: Ints, R: Array, B: Array, p: Array, w: Array, dw: Array, b: Array,
    own: Array, h: Array, v: Array, u: Array, turned: Array, m: int,
) -> None:  # fmt: skip
    """own: (6, m) force and moment about the base origin, base frame, that move body i."""
    mass, I_xx, I_xy, I_yy, I_xz, I_yz, I_zz = phi[0], phi[4], phi[5], phi[6], phi[7], phi[8], phi[9]
    for x in axes[0]:
        for t in range(m):
            h[x, t] = R[i, 3 * x, t] * phi[1] + R[i, 3 * x + 1, t] * phi[2] + R[i, 3 * x + 2, t] * phi[3]
    for x in axes[0]:
        for t in range(m):
            own[x, t] = (
                mass * b[i, x, t]
                + B[i, 3 * x, t] * h[0, t] + B[i, 3 * x + 1, t] * h[1, t] + B[i, 3 * x + 2, t] * h[2, t]
            )  # fmt: skip
    for k in axes[0]:  # the rates in the body frame, where its inertia is constant
        for t in range(m):
            v[k, t] = R[i, k, t] * w[i, 0, t] + R[i, 3 + k, t] * w[i, 1, t] + R[i, 6 + k, t] * w[i, 2, t]
        for t in range(m):
            u[k, t] = R[i, k, t] * dw[i, 0, t] + R[i, 3 + k, t] * dw[i, 1, t] + R[i, 6 + k, t] * dw[i, 2, t]
    for t in range(m):
        L_x = I_xx * v[0, t] + I_xy * v[1, t] + I_xz * v[2, t]
        L_y = I_xy * v[0, t] + I_yy * v[1, t] + I_yz * v[2, t]
        L_z = I_xz * v[0, t] + I_yz * v[1, t] + I_zz * v[2, t]
        turned[0, t] = I_xx * u[0, t] + I_xy * u[1, t] + I_xz * u[2, t] + v[1, t] * L_z - v[2, t] * L_y
        turned[1, t] = I_xy * u[0, t] + I_yy * u[1, t] + I_yz * u[2, t] + v[2, t] * L_x - v[0, t] * L_z
        turned[2, t] = I_xz * u[0, t] + I_yz * u[1, t] + I_zz * u[2, t] + v[0, t] * L_y - v[1, t] * L_x
    for x in axes[0]:
        y, z = axes[1, x], axes[2, x]
        for t in range(m):
            own[3 + x, t] = (
                R[i, 3 * x, t] * turned[0, t] + R[i, 3 * x + 1, t] * turned[1, t] + R[i, 3 * x + 2, t] * turned[2, t]
                + h[y, t] * b[i, z, t] - h[z, t] * b[i, y, t]
                + p[i, y, t] * own[z, t] - p[i, z, t] * own[y, t]
            )  # fmt: skip


@fused()
def _into_frame(
    body: int, rotation: Array, place: Array, axes: Ints, R: Array, p: Array, wrench: Array,
    h: Array, v: Array, u: Array, m: int,
) -> None:  # fmt: skip
    """u, v: (3, m) force, and moment about the origin of a frame of this body, in the frame. wrench: (6, m) about the
    base origin."""
    for x in axes[0]:
        for t in range(m):
            h[x, t] = (
                p[body, x, t]
                + R[body, 3 * x, t] * place[0] + R[body, 3 * x + 1, t] * place[1] + R[body, 3 * x + 2, t] * place[2]
            )  # fmt: skip
    for x in axes[0]:
        y, z = axes[1, x], axes[2, x]
        for t in range(m):
            v[x, t] = wrench[3 + x, t] - (h[y, t] * wrench[z, t] - h[z, t] * wrench[y, t])
    for t in range(m):
        f_0, f_1, f_2, m_0, m_1, m_2 = wrench[0, t], wrench[1, t], wrench[2, t], v[0, t], v[1, t], v[2, t]
        a_0 = R[body, 0, t] * f_0 + R[body, 3, t] * f_1 + R[body, 6, t] * f_2
        a_1 = R[body, 1, t] * f_0 + R[body, 4, t] * f_1 + R[body, 7, t] * f_2
        a_2 = R[body, 2, t] * f_0 + R[body, 5, t] * f_1 + R[body, 8, t] * f_2
        c_0 = R[body, 0, t] * m_0 + R[body, 3, t] * m_1 + R[body, 6, t] * m_2
        c_1 = R[body, 1, t] * m_0 + R[body, 4, t] * m_1 + R[body, 7, t] * m_2
        c_2 = R[body, 2, t] * m_0 + R[body, 5, t] * m_1 + R[body, 8, t] * m_2
        for x in axes[0]:
            u[x, t] = rotation[x] * a_0 + rotation[3 + x] * a_1 + rotation[6 + x] * a_2
            v[x, t] = rotation[x] * c_0 + rotation[3 + x] * c_1 + rotation[6 + x] * c_2
