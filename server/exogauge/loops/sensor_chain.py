"""How the end of a chain of joints moves, and its slopes by every joint's position, rate and acceleration."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from exogauge.loops.compiled import compiled

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


@compiled(
    "f8[:,:,::1], f8[:,::1], f8[:,::1], b1[::1], i8[::1], f8[:,:,::1], f8[:,::1], f8[:,::1], f8[::1], f8[::1], "
    "f8[:,:,::1], f8[:,:,::1], f8[:,::1], f8[:,:,:,::1]",
)
def end_motion(
    R_before: Array, p_before: Array, axis: Array, slides: Bools, dof: Ints, R_after: Array, p_after: Array,
    R_end: Array, p_end: Array, gravity: Array, state: Array, R_out: Array, out: Array, slopes: Array,
) -> None:  # fmt: skip
    """n joints from the base outward, each T_before, motion, T_after; then the end's pose in the last body.

    state: (T, J, 3) q, q̇, q̈ of the columns that `dof` names. gravity: (3,) in the base. R_out: (T, 3, 3) R_base_end.
    out: (T, 9) a - g of the end's origin (a classical), α, ω, in the end's axes. slopes: (T, J, 9, 3) of these.

    Spatial vectors are [linear; angular] about the end's origin, in the base's axes: with v_λ, a_λ of the body before
    a joint, J its unit motion and w = v_λ x J, ∂v/∂q = w, ∂a/∂q = a_λ x J + w x (v - v_λ), ∂a/∂q̇ = w + J x (v - v_λ)
    in the moving frame.
    """
    n = len(dof)
    z, o = np.empty((n, 3)), np.empty((n, 3))
    J, W = np.zeros((n, 6)), np.empty((n, 6))
    v, a = np.empty((n + 1, 6)), np.empty((n + 1, 6))
    R, S, p, t = np.empty((3, 3)), np.empty((3, 3)), np.empty(3), np.empty(6)
    d, u = np.empty(6), np.empty(6)
    slopes[:] = 0.0
    for k in range(len(state)):
        R[:] = 0.0
        R[0, 0], R[1, 1], R[2, 2] = 1.0, 1.0, 1.0
        p[:] = 0.0
        for j in range(n):
            _go(R, p, R_before[j], p_before[j], S)
            for i in range(3):
                z[j, i] = R[i, 0] * axis[j, 0] + R[i, 1] * axis[j, 1] + R[i, 2] * axis[j, 2]
                o[j, i] = p[i]
            q = state[k, dof[j], 0]
            if slides[j]:
                for i in range(3):
                    p[i] += q * z[j, i]
            else:
                _turn(R, axis[j], q, S)
            _go(R, p, R_after[j], p_after[j], S)
        _go(R, p, R_end, p_end, S)
        v[0], a[0] = 0.0, 0.0
        a[0, 0], a[0, 1], a[0, 2] = -gravity[0], -gravity[1], -gravity[2]
        for j in range(n):
            if slides[j]:
                for i in range(3):
                    J[j, i], J[j, 3 + i] = z[j, i], 0.0
            else:
                x, y, w = p[0] - o[j, 0], p[1] - o[j, 1], p[2] - o[j, 2]
                J[j, 0] = z[j, 1] * w - z[j, 2] * y
                J[j, 1] = z[j, 2] * x - z[j, 0] * w
                J[j, 2] = z[j, 0] * y - z[j, 1] * x
                J[j, 3], J[j, 4], J[j, 5] = z[j, 0], z[j, 1], z[j, 2]
            _cross(v[j], J[j], W[j])
            dq, ddq = state[k, dof[j], 1], state[k, dof[j], 2]
            for i in range(6):
                v[j + 1, i] = v[j, i] + J[j, i] * dq
                a[j + 1, i] = a[j, i] + J[j, i] * ddq + W[j, i] * dq
        V, A = v[n], a[n]
        t[0] = A[0] + V[4] * V[2] - V[5] * V[1]
        t[1] = A[1] + V[5] * V[0] - V[3] * V[2]
        t[2] = A[2] + V[3] * V[1] - V[4] * V[0]
        for i in range(3):
            for m in range(3):
                R_out[k, i, m] = R[i, m]
            out[k, i] = R[0, i] * t[0] + R[1, i] * t[1] + R[2, i] * t[2]
            out[k, 3 + i] = R[0, i] * A[3] + R[1, i] * A[4] + R[2, i] * A[5]
            out[k, 6 + i] = R[0, i] * V[3] + R[1, i] * V[4] + R[2, i] * V[5]
        for j in range(n):
            to = slopes[k, dof[j]]
            for i in range(6):
                t[i] = V[i] - v[j, i]
            _cross(a[j], J[j], d)
            _cross(W[j], t, u)
            for i in range(6):
                d[i] += u[i]
            _put(R, V, W[j], d, to, 0)
            _cross(J[j], t, d)
            for i in range(6):
                d[i] += W[j, i]
            _put(R, V, J[j], d, to, 1)
            u[:] = 0.0
            _put(R, V, u, J[j], to, 2)


@compiled()
def _go(R: Array, p: Array, R_next: Array, p_next: Array, S: Array) -> None:
    """(R, p) <- (R, p) · (R_next, p_next)."""
    for i in range(3):
        p[i] += R[i, 0] * p_next[0] + R[i, 1] * p_next[1] + R[i, 2] * p_next[2]
        for m in range(3):
            S[i, m] = R[i, 0] * R_next[0, m] + R[i, 1] * R_next[1, m] + R[i, 2] * R_next[2, m]
    R[:] = S


@compiled()
def _turn(R: Array, e: Array, q: float, S: Array) -> None:
    """R <- R · turn by q about e (Rodrigues)."""
    c, s = math.cos(q), math.sin(q)
    for i in range(3):
        along = (1.0 - c) * (R[i, 0] * e[0] + R[i, 1] * e[1] + R[i, 2] * e[2])
        S[i, 0] = c * R[i, 0] + along * e[0] + s * (R[i, 1] * e[2] - R[i, 2] * e[1])
        S[i, 1] = c * R[i, 1] + along * e[1] + s * (R[i, 2] * e[0] - R[i, 0] * e[2])
        S[i, 2] = c * R[i, 2] + along * e[2] + s * (R[i, 0] * e[1] - R[i, 1] * e[0])
    R[:] = S


@compiled()
def _cross(v: Array, m: Array, out: Array) -> None:
    """out <- v x m of motions [linear; angular]."""
    out[0] = v[4] * m[2] - v[5] * m[1] + v[1] * m[5] - v[2] * m[4]
    out[1] = v[5] * m[0] - v[3] * m[2] + v[2] * m[3] - v[0] * m[5]
    out[2] = v[3] * m[1] - v[4] * m[0] + v[0] * m[4] - v[1] * m[3]
    out[3] = v[4] * m[5] - v[5] * m[4]
    out[4] = v[5] * m[3] - v[3] * m[5]
    out[5] = v[3] * m[4] - v[4] * m[3]


@compiled()
def _put(R: Array, V: Array, dv: Array, da: Array, to: Array, order: int) -> None:
    """to (9, 3), column `order` <- what changes of a - g, α, ω where v changes by dv and a by da."""
    x = da[0] + dv[4] * V[2] - dv[5] * V[1] + V[4] * dv[2] - V[5] * dv[1]
    y = da[1] + dv[5] * V[0] - dv[3] * V[2] + V[5] * dv[0] - V[3] * dv[2]
    w = da[2] + dv[3] * V[1] - dv[4] * V[0] + V[3] * dv[1] - V[4] * dv[0]
    for i in range(3):
        to[i, order] = R[0, i] * x + R[1, i] * y + R[2, i] * w
        to[3 + i, order] = R[0, i] * da[3] + R[1, i] * da[4] + R[2, i] * da[5]
        to[6 + i, order] = R[0, i] * dv[3] + R[1, i] * dv[4] + R[2, i] * dv[5]
