"""A body of joints in many frames: where its parts are, and normal equations of points on it, for `motion.fit`.

Frame by frame: what one frame needs stays in the cache.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.loops.compiled import fused

Array = NDArray[np.float64]
Ints = NDArray[np.intp]
Bools = NDArray[np.bool_]


@fused("i8[::1], b1[::1], i8[::1], f8[::1], f8[:,::1], f8[:,::1], f8[:,::1], f8[:,:,:,::1], f8[:,:,::1]")
def move_body(
    parent: Ints, prismatic: Bools, axis: Ints, sign: Array, offset: Array, cos: Array, sin: Array, R: Array, p: Array
) -> None:
    """R (T, K, 3, 3) and p (T, K, 3), as `Pose` has them. axis, sign: (K,) which axis of its part a joint has.

    offset: (K, 3) [m] of a joint in the part above it; parents first, -1 above the root. cos, sin: (T, K) of a turn; of
    what slides, sin is the way.
    """
    for t in range(R.shape[0]):
        for k in range(R.shape[1]):
            above = parent[k]
            for x in range(3):
                if above < 0:
                    p[t, k, x] = offset[k, x]
                    for y in range(3):
                        R[t, k, x, y] = 1.0 if x == y else 0.0
                else:
                    p[t, k, x] = p[t, above, x]
                    for y in range(3):
                        p[t, k, x] += R[t, above, x, y] * offset[k, y]
                        R[t, k, x, y] = R[t, above, x, y]
            a = axis[k]
            if prismatic[k]:
                for x in range(3):
                    p[t, k, x] += sign[k] * sin[t, k] * R[t, k, x, a]
                continue
            b, c = (a + 1) % 3, (a + 2) % 3
            for x in range(3):
                old_b, old_c = R[t, k, x, b], R[t, k, x, c]
                R[t, k, x, b] = old_b * cos[t, k] + old_c * sign[k] * sin[t, k]
                R[t, k, x, c] = old_c * cos[t, k] - old_b * sign[k] * sin[t, k]


@fused(
    "i8[::1], b1[::1], i8[::1], f8[::1], i8[::1], f8[:,:,:,::1], f8[:,:,::1], f8[:,:,::1], f8[:,:,::1], f8[:,::1], "
    "f8[:,:,::1], f8[:,::1]"
)
def normal_equations(
    parent: Ints, prismatic: Bools, axis: Ints, sign: Array, joint: Ints, R: Array, p: Array, place: Array, left: Array,
    weight: Array, A: Array, g: Array,
) -> None:  # fmt: skip
    """A (T, K, K) and g (T, K) of points `place` (T, M, 3) of which `left` (T, M, 3) is left, as `kinematics.normal`
    has them. joint: (M,) that carries each; the others as in `move_body`."""
    T, K, M = A.shape[0], A.shape[1], place.shape[1]
    # of what each joint moves: the sum of weights, of w p, of w p pᵀ (xx, yy, zz, xy, xz, yz), of p × w r and of w r
    sums, moves = np.empty((K, 16)), np.empty((K, 6))
    for t in range(T):
        here = p[t, K - 1]  # moments about a point of the body, for their digits
        for k in range(K):
            for x in range(16):
                sums[k, x] = 0.0
            a, s = axis[k], sign[k]
            u, v, w = s * R[t, k, 0, a], s * R[t, k, 1, a], s * R[t, k, 2, a]
            if prismatic[k]:
                moves[k, 0] = moves[k, 1] = moves[k, 2] = 0.0
                moves[k, 3], moves[k, 4], moves[k, 5] = u, v, w
            else:
                x, y, z = p[t, k, 0] - here[0], p[t, k, 1] - here[1], p[t, k, 2] - here[2]
                moves[k, 0], moves[k, 1], moves[k, 2] = u, v, w
                moves[k, 3], moves[k, 4], moves[k, 5] = y * w - z * v, z * u - x * w, x * v - y * u
        for m in range(M):
            W = weight[t, m]
            if W == 0.0:
                continue
            to = sums[joint[m]]
            x, y, z = place[t, m, 0] - here[0], place[t, m, 1] - here[1], place[t, m, 2] - here[2]
            u, v, w = W * left[t, m, 0], W * left[t, m, 1], W * left[t, m, 2]
            to[0] += W
            to[1] += W * x
            to[2] += W * y
            to[3] += W * z
            to[4] += W * x * x
            to[5] += W * y * y
            to[6] += W * z * z
            to[7] += W * x * y
            to[8] += W * x * z
            to[9] += W * y * z
            to[10] += y * w - z * v
            to[11] += z * u - x * w
            to[12] += x * v - y * u
            to[13] += u
            to[14] += v
            to[15] += w
        for k in range(K - 1, -1, -1):
            own, move, above = sums[k], moves[k], parent[k]
            if above >= 0:
                for x in range(16):
                    sums[above, x] += own[x]
            g[t, k] = (
                move[0] * own[10] + move[1] * own[11] + move[2] * own[12]
                + move[3] * own[13] + move[4] * own[14] + move[5] * own[15]
            )  # fmt: skip
            a, b, c = move[0], move[1], move[2]
            u, v, w = move[3], move[4], move[5]
            x, y, z = own[1], own[2], own[3]
            f_x = b * z - c * y + own[0] * u
            f_y = c * x - a * z + own[0] * v
            f_z = a * y - b * x + own[0] * w
            square = own[4] + own[5] + own[6]
            n_x = square * a - own[4] * a - own[7] * b - own[8] * c + y * w - z * v
            n_y = square * b - own[7] * a - own[5] * b - own[9] * c + z * u - x * w
            n_z = square * c - own[8] * a - own[9] * b - own[6] * c + x * v - y * u
            j = k
            while j >= 0:
                other = moves[j]
                A[t, j, k] = (
                    other[0] * n_x + other[1] * n_y + other[2] * n_z + other[3] * f_x + other[4] * f_y + other[5] * f_z
                )
                A[t, k, j] = A[t, j, k]
                j = parent[j]
